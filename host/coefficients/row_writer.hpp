// SPDX-License-Identifier: Apache-2.0
// A frame as a line of a coefficient file, with the columns of columns.hpp. Cells that need a surface are empty without one,
// sd cells also when the deviations are not known.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dsp/optics/surface_model.hpp"
#include "host/coefficients/columns.hpp"
#include "proto/messages.hpp"

namespace srd::host {

// What a line says, of a node's record or of a frame that srd reconstruct fitted.
struct RowContent {
  std::string_view node;
  std::uint64_t boot = 0;
  std::uint64_t sequence = 0;
  proto::Stamp stamp;
  proto::FrameStatus status = proto::FrameStatus::kSearching;
  std::uint32_t corners_expected = 0, corners_found = 0, corners_used = 0;
  std::string_view metric;                 // a name that error_unit() knows
  int modes = 0;                           // of the file
  double mean_error = 0;                   // in the metric's unit
  double height_mm = 0;                    // at the pattern's centre
  dsp::Coefficients<double> coefficients;  // mm, one a mode; empty: no surface
  dsp::Coefficients<double> deviations;    // mm, one a mode; empty: not known
  dsp::Coefficients<double> systematic;    // deviations, mm, one a mode; empty: not known
  double systematic_height = 0;            // mm; with systematic
};

// Of a record; from outlives the row.
[[nodiscard]] RowContent row_content(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame);

// Numbers that a float holds read back as that float; others keep nine digits, deviations four. One that is not finite gives
// an empty cell.
void append_row(const RowContent& row, std::string& out);

// The modes of a coefficient file's header (without line end); nullopt when it is another.
[[nodiscard]] std::optional<dsp::ModeList> modes_of_header(std::string_view header);

// Surface height at the pattern's centre, mm; the frame has a surface.
[[nodiscard]] double height_at_centre(const proto::CoefficientFrame& frame);

}  // namespace srd::host
