// SPDX-License-Identifier: Apache-2.0
// From a run of coefficients to the files of `srd plot`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "host/coefficients/run_geometry.hpp"

namespace srd::host {

struct PlotOptions {
  std::filesystem::path file;                  // coefficients
  std::optional<std::filesystem::path> truth;  // truth.csv
  std::optional<std::filesystem::path> out;    // folder; not given: the one of `file`
  std::string node;                            // "": the only one
  std::optional<std::uint64_t> frame;          // sequence of the surface shown; not given: the last with a surface
  bool by_order = false;                       // truth matched by order, not by time
  bool force = false;                          // replace files that are there
  GeometryOptions geometry;
};

struct PlotFiles {
  std::vector<std::filesystem::path> written;  // the page first
  std::vector<std::string> notes;              // figures left out and why, rows left out
};

// STEM.html and STEM-<figure>.png, STEM being the name of `file`. Nothing is written when one of them is
// there already (kUsage, unless force), or when any input is wrong.
[[nodiscard]] Outcome<PlotFiles> plot(const PlotOptions& options);

}  // namespace srd::host
