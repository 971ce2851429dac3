// SPDX-License-Identifier: Apache-2.0
#include "proto/plain_word.hpp"

#include <gtest/gtest.h>

namespace srd::proto {
namespace {

TEST(PlainWord, WhatTableProgramsTakeForAValueIsNone) {
  for (const char* word : {"1",    "007",   "1.5",  "-3",   "1e5", "1E5",      "1.5e-3",   "2d4",   "0x1F",  "1L",
                           "2i",   "-",     "_",    ".",    "1-2", "3.4.2026", "NA",       "na",    "n.a.",  "NaN",
                           "-nan", "NULL",  "null", "None", "inf", "-Inf",     "Infinity", "TRUE",  "true",  "T",
                           "f",    "False", "yes",  "no",   "NaT", "mar-1",    "MARCH1",   "Sept2", "1-may", "DEC-2026"})
    EXPECT_TRUE(reads_as_value(word)) << word;
}

TEST(PlainWord, NamesOfNodesAreWords) {
  for (const char* word :
       {"node-1", "cam-1",      "flume",   "flume.west", "a",     "bench", "1st-camera", "north", "x1",  "nana",     "info",
        "inf-1",  "true-north", "maria-1", "decade-1",   "march", "e5",    "node-1e5",   "left2", "2nd", "simulated"})
    EXPECT_FALSE(reads_as_value(word)) << word;
}

}  // namespace
}  // namespace srd::proto
