// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/row_writer.hpp"

#include <array>
#include <charconv>
#include <vector>

#include "host/coefficients/columns.hpp"

namespace srd::host {
namespace {

template <class Number, class... Format>
void append_number(std::string& out, Number number, Format... format) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number, format...);
  if (error == std::errc{}) out.append(text.data(), end);
}

template <class Number, class... Format>
void append_cell(std::string& out, Number number, Format... format) {
  out += ',';
  append_number(out, number, format...);
}

// 0 on the wire: not known.
template <class Number>
void append_known(std::string& out, Number number) {
  if (number != 0)
    append_cell(out, number);
  else
    out += ',';
}

}  // namespace

std::string joined_names(const dsp::ModeList& modes, char between) {
  std::string names;
  for (const dsp::Mode& mode : modes) {
    if (!names.empty()) names += between;
    names += mode.name().data();
  }
  return names;
}

std::optional<dsp::ModeList> modes_of_header(std::string_view header) {
  if (!header.starts_with(kFixedColumns)) return std::nullopt;
  std::vector<dsp::Mode> modes;
  for (std::string_view rest = header.substr(kFixedColumns.size()); !rest.empty();) {
    rest.remove_prefix(1);
    const std::string_view name = rest.substr(0, rest.find(','));
    const auto mode = dsp::Mode::parse(name);
    if (!mode) break;
    modes.push_back(*mode);
    rest.remove_prefix(name.size());
  }
  const auto list = dsp::ModeList::make(modes);
  if (!list || coefficient_header(*list) != std::string(header) + "\n") return std::nullopt;
  return *list;
}

double height_at_centre(const proto::CoefficientFrame& frame) {
  return frame.model.cast<double>().height(frame.coefficients.cast<double>(), static_cast<double>(frame.centre_x_mm),
                                           static_cast<double>(frame.centre_y_mm));
}

namespace {

// From the height on, empty without a surface.
void append_surface(const proto::CoefficientFrame& frame, std::string& out) {
  const auto n = static_cast<std::size_t>(frame.model.modes.size());
  if (!frame.has_surface()) {
    out.append(1 + 2 * n, ',');
    return;
  }
  append_cell(out, static_cast<float>(height_at_centre(frame)));
  for (const float a : frame.coefficients) append_cell(out, a);
  const dsp::Coefficients<double> deviations = proto::standard_deviations(frame.information);
  if (deviations.size() == 0)
    out.append(n, ',');
  else
    for (const double sd : deviations) append_cell(out, sd, std::chars_format::general, 4);
}

}  // namespace

void append_csv_row(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame, std::string& out) {
  out += from.node.view();
  out += "," + boot_text(from.boot);
  append_cell(out, sequence);
  append_cell(out, frame.stamp.sensor_time_ns);
  out += std::string(",") + to_string(frame.stamp.clock);
  out += std::string(",") + to_string(frame.status);
  append_cell(out, frame.corners_expected);
  append_cell(out, frame.corners_found);
  append_cell(out, frame.corners_used);
  if (frame.has_surface())
    append_cell(out, frame.mean_error);
  else
    out += ',';
  out += std::string(",") + proto::to_string(frame.metric);
  append_surface(frame, out);
  append_known(out, frame.stamp.wall_time_ns);
  append_known(out, frame.stamp.wall_uncertainty_ns);
  out += '\n';
}

}  // namespace srd::host
