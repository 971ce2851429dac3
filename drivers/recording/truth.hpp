// SPDX-License-Identifier: Apache-2.0
// truth.csv: the surface that made each frame. frame,time_ns,<modes>, coefficients in mm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd {

struct TruthRow {
  std::uint64_t frame = 0;  // the frame's sequence
  std::int64_t time_ns = 0;
  dsp::Coefficients<double> coefficients;  // mm, in the order of Truth::modes
};

struct Truth {
  dsp::ModeList modes;
  std::vector<TruthRow> rows;
};

// kInput: an unknown or repeated mode, a row of another length, a number that is none; with the line.
[[nodiscard]] Outcome<Truth> read_truth(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_truth(const std::filesystem::path& file, const Truth& truth);

}  // namespace srd
