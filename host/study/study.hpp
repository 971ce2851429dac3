// SPDX-License-Identifier: Apache-2.0
// `srd study`: how precise corners and surfaces are on images with known truth, written as tables, figures and a page.
#pragma once

#include <filesystem>
#include <vector>

#include "host/study/corner_study.hpp"

namespace srd::study {

struct StudyOptions {
  std::filesystem::path out;
  bool quick = false;  // few conditions, boards and draws: seconds in place of a minute
  bool force = false;  // replace files that are there
  Progress progress;   // may be empty
};

// study.html, study-corners.png, study-surface.png, corners.csv, surface.csv. kUsage when one of them is there and
// force is not given; nothing is done then. Returns the files, the page first.
[[nodiscard]] Outcome<std::vector<std::filesystem::path>> study(const StudyOptions& options);

}  // namespace srd::study
