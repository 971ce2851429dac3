// SPDX-License-Identifier: Apache-2.0
// A frame as a line of CSV with the columns of columns.hpp. Cells that need a surface are empty without one, sd
// cells also when the information is not known.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dsp/optics/surface_model.hpp"
#include "proto/messages.hpp"

namespace srd::host {

// The modes of a coefficient file's header (without line end); nullopt when it is another.
[[nodiscard]] std::optional<dsp::ModeList> modes_of_header(std::string_view header);

void append_csv_row(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame, std::string& out);

// Surface height at the pattern's centre, mm; the frame has a surface.
[[nodiscard]] double height_at_centre(const proto::CoefficientFrame& frame);

// "A00-B-C": for file names.
[[nodiscard]] std::string joined_names(const dsp::ModeList& modes, char between);

}  // namespace srd::host
