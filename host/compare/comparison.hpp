// SPDX-License-Identifier: Apache-2.0
// Estimated against true surfaces, frame by frame. Shared by `srd compare` and `srd plot`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/truth.hpp"
#include "host/coefficients/row_reader.hpp"
#include "host/coefficients/run_geometry.hpp"

namespace srd::host {

enum class MatchBy : unsigned char {
  kTime,   // time_ns equal to the last digit
  kOrder,  // first row with first row, and so on
};

// Estimated minus true of one frame.
struct FrameError {
  std::size_t row = 0;        // into CoefficientRun::rows
  std::size_t truth_row = 0;  // into Truth::rows
  std::vector<double> mode;   // mm, in the order of Comparison::modes
  double height = 0;          // at the pattern's centre, mm; NaN without geometry
  double surface_rms = 0;     // over RunGeometry::places, mm; NaN without geometry
};

struct ModeSummary {
  double rms = 0, mean = 0, largest = 0;  // of estimated minus true, mm; largest of |.|
  double normalised = 0;   // rms of error / stated standard deviation: 1 when the deviations are right; NaN without
  double scatter = 0;      // the same of what each error is off their mean, which a systematic error does not touch
  double systematic = 0;   // rms of the stated systematic deviation, mm; NaN where none is stated
  double true_spread = 0;  // standard deviation of the true coefficient over the frames, mm: the size of the signal
};

struct Comparison {
  dsp::ModeList modes;                     // those that both sides have
  std::size_t matched = 0;                 // rows with a true counterpart, with or without a surface
  std::vector<FrameError> frames;          // those with a surface, at least one
  std::vector<ModeSummary> summary;        // one a mode
  double height_rms = 0, height_mean = 0;  // mm; NaN without geometry
  double height_systematic = 0;            // rms of the stated systematic deviation, mm; NaN where none is stated
  double surface_rms = 0,
         surface_largest = 0;  // rms over frames and places; the worst frame's; NaN without geometry
  std::size_t worst = 0;       // the worst frame, into frames
};

// kInput when no frame matches, the row counts differ (kOrder) or the sides share no mode.
[[nodiscard]] Outcome<Comparison> compare(const CoefficientRun& run, const Truth& truth, const std::string& truth_file,
                                          MatchBy by, const std::optional<RunGeometry>& geometry);

// The table that `srd compare` prints; lines end in '\n'.
[[nodiscard]] std::string comparison_text(const CoefficientRun& run, const Truth& truth, const Comparison& comparison,
                                          const std::optional<RunGeometry>& geometry);

}  // namespace srd::host
