// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/problem.hpp"

namespace srd {

std::string Problem::text() const {
  std::string out = "error: ";
  if (!where.empty()) out += where + ": ";
  out += what + "\n";
  if (!expected.empty()) out += "  expected: " + expected + "\n";
  if (!found.empty()) out += "  found: " + found + "\n";
  if (!advice.empty()) out += "  try: " + advice + "\n";
  return out;
}

}  // namespace srd
