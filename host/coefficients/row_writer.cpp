// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/row_writer.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "drivers/support/text_file.hpp"

namespace srd::host {
namespace {

template <class Number, class... Format>
void append_cell(std::string& out, Number number, Format... format) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number, format...);
  out += ',';
  if (error == std::errc{}) out.append(text.data(), end);
}

void append_text(std::string& out, std::string_view text) { (out += ',') += text; }

void append_real(std::string& out, double number) {
  if (!std::isfinite(number))
    out += ',';
  else if (const auto single = static_cast<float>(number); static_cast<double>(single) == number)
    append_cell(out, single);
  else
    append_cell(out, number, std::chars_format::general, 9);
}

void append_deviation(double mm, std::string& out) {
  if (std::isfinite(mm))
    append_cell(out, mm, std::chars_format::general, 4);
  else
    out += ',';
}

// 0: not known.
template <class Number>
void append_known(std::string& out, Number number) {
  if (number != 0)
    append_cell(out, number);
  else
    out += ',';
}

// From the height on, empty without a surface.
void append_surface(const RowContent& row, std::string& out) {
  const auto n = static_cast<std::size_t>(row.modes);
  if (row.coefficients.size() == 0) {
    out.append(1 + 2 * n, ',');
    return;
  }
  append_real(out, row.height_mm);
  for (int j = 0; j < row.modes; ++j) append_real(out, row.coefficients[j]);
  for (int j = 0; j < row.modes; ++j) append_deviation(j < row.deviations.size() ? row.deviations[j] : std::nan(""), out);
}

void append_systematic(const RowContent& row, std::string& out) {
  const bool known = row.coefficients.size() > 0 && row.systematic.size() == row.modes;
  for (int j = 0; j < row.modes; ++j) append_deviation(known ? row.systematic[j] : std::nan(""), out);
  append_deviation(known ? row.systematic_height : std::nan(""), out);
}

}  // namespace

std::optional<dsp::ModeList> modes_of_header(std::string_view header) {
  if (!header.starts_with(kFixedColumns)) return std::nullopt;
  std::vector<dsp::Mode> modes;
  const std::vector<std::string_view> cells = split_commas(header);
  for (std::size_t i = split_commas(kFixedColumns).size(); i < cells.size(); ++i) {
    const auto mode = dsp::Mode::parse(cells[i]);
    if (!mode) break;
    modes.push_back(*mode);
  }
  const auto list = dsp::ModeList::make(modes);
  if (!list || coefficient_header(*list) != std::string(header) + "\n") return std::nullopt;
  return *list;
}

double height_at_centre(const proto::CoefficientFrame& frame) {
  return frame.model.cast<double>().height(frame.coefficients.cast<double>(), static_cast<double>(frame.centre_x_mm),
                                           static_cast<double>(frame.centre_y_mm));
}

RowContent row_content(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  RowContent row;
  row.node = from.node.view();
  row.boot = from.boot;
  row.sequence = sequence;
  row.stamp = frame.stamp;
  row.status = frame.status;
  row.corners_expected = frame.corners_expected;
  row.corners_found = frame.corners_found;
  row.corners_used = frame.corners_used;
  row.metric = dsp::to_string(frame.metric);
  row.modes = frame.model.modes.size();
  if (!frame.has_surface()) return row;
  row.mean_error = static_cast<double>(frame.mean_error);
  row.height_mm = static_cast<double>(static_cast<float>(height_at_centre(frame)));
  row.coefficients = frame.coefficients.cast<double>();
  row.deviations = proto::standard_deviations(frame.information);
  row.systematic = frame.systematic.deviation.cast<double>();
  row.systematic_height = static_cast<double>(frame.systematic.height_mm);
  return row;
}

void append_row(const RowContent& row, std::string& out) {
  out += row.node;
  append_text(out, boot_text(row.boot));
  append_cell(out, row.sequence);
  append_cell(out, row.stamp.sensor_time_ns);
  append_text(out, to_string(row.stamp.clock));
  append_text(out, proto::to_string(row.status));
  append_cell(out, row.corners_expected);
  append_cell(out, row.corners_found);
  append_cell(out, row.corners_used);
  if (row.coefficients.size() > 0)
    append_real(out, row.mean_error);
  else
    out += ',';
  append_text(out, row.metric);
  append_surface(row, out);
  append_known(out, row.stamp.wall_time_ns);
  append_known(out, row.stamp.wall_uncertainty_ns);
  append_systematic(row, out);
  out += '\n';
}

}  // namespace srd::host
