// SPDX-License-Identifier: Apache-2.0
#include "host/run/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/support/text_file.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/coefficients/pattern_extent.hpp"
#include "host/coefficients/row_writer.hpp"
#include "host/run/found_index.hpp"
#include "host/run/systematic.hpp"

namespace srd::host {

namespace {

constexpr const char* kNode = "reconstruct";

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "";
  std::array<char, 400> buffer;
  const int length = std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

RowContent row_content(const RunPlan& plan, const PatternExtent& pattern, const FrameRecord& frame) {
  RowContent row;
  row.node = kNode;
  row.sequence = frame.sequence;
  row.stamp.sensor_time_ns = frame.time_ns;
  row.stamp.clock = plan.times_known ? ClockId::kRecording : ClockId::kUnknown;
  row.status = frame.status;
  row.corners_expected = static_cast<std::uint32_t>(frame.expected);
  row.corners_found = static_cast<std::uint32_t>(frame.found);
  row.metric = metric_name(plan);
  row.modes = plan.model.modes.size();
  if (!frame.has_surface()) return row;
  const dsp::Estimate<double>& estimate = frame.estimate;
  row.corners_used = static_cast<std::uint32_t>(estimate.corners_used);
  row.mean_error = estimate.mean_error;
  row.height_mm = plan.model.height(estimate.coefficients, pattern.x_centre(), pattern.y_centre());
  row.coefficients = estimate.coefficients.head(row.modes);
  if (frame.systematic) {
    row.systematic = frame.systematic->deviation;
    row.systematic_height = frame.systematic->deviation_at(plan.model, {pattern.x_centre(), pattern.y_centre()});
  }
  row.deviations = estimate.standard_deviation.head(std::min<Eigen::Index>(row.modes, estimate.standard_deviation.size()));
  return row;
}

}  // namespace

const char* metric_name(const RunPlan& plan) { return plan.pattern_run ? kPatternMetric : dsp::to_string(plan.options.metric); }

const char* metric_unit(const RunPlan& plan) { return error_unit(metric_name(plan)); }

std::string series_csv(const RunPlan& plan, const RunResult& result) {
  std::string text = coefficient_header(plan.model.modes);
  const PatternExtent pattern = extent_of(plan.points);
  for (const FrameRecord& frame : result.frames) append_row(row_content(plan, pattern, frame), text);
  return text;
}

std::string series_model(const RunPlan& plan, const RunResult& result) {
  return model_file_text(
      {{{kNode, plan.model, index_of(plan, result), extent_of(plan.points), plates_of(plan.media), error_sources(plan)}}});
}

double pattern_height(const RunPlan& plan, const dsp::Coefficients<double>& surface) {
  double sum = 0;
  for (const auto& p : plan.points) sum += plan.model.height(surface, p.x(), p.y());
  return sum / static_cast<double>(plan.points.size());
}

RunMeans means(const RunPlan& plan, const RunResult& result) {
  RunMeans m;
  double squares = 0;
  for (const FrameRecord& frame : result.frames) {
    m.seconds_a_frame += frame.seconds / static_cast<double>(result.frames.size());
    if (!frame.has_surface()) continue;
    ++m.surfaces;
    m.error += frame.estimate.mean_error;
    m.height_mm += pattern_height(plan, frame.estimate.coefficients);
    squares += frame.estimate.reprojection_rms * frame.estimate.reprojection_rms;
  }
  if (m.surfaces == 0) return m;
  const double n = static_cast<double>(m.surfaces);
  m.error /= n;
  m.height_mm /= n;
  m.reprojection_rms = std::sqrt(squares / n);
  return m;
}

std::string summary_text(const RunPlan& plan, const RunResult& result, const std::vector<std::string>& head,
                         const std::vector<std::string>& warnings) {
  const RunMeans m = means(plan, result);
  const std::string unit = metric_unit(plan);
  std::string text;
  for (const std::string& line : head) text += line + "\n";
  text += "refractive index: " + index_text(plan, result) + " (air " + number_text(plan.media.air) + ")\n";
  text += "surface: " + joined(plan.model.modes, " ") + ", Lx " + number_text(plan.model.lx) + " mm, Ly " +
          number_text(plan.model.ly) + " mm\n";
  text += "metric: " + std::string(metric_name(plan)) + ", errors in " + unit +
          (plan.options.loss == dsp::Loss::kNone ? "" : std::string(", loss: ") + to_string(plan.options.loss)) + "\n";
  text += "frames: " + std::to_string(result.frames.size()) + ", with a surface: " + std::to_string(m.surfaces) + "\n";
  if (m.surfaces > 0) {
    text += "mean error: " + fixed(m.error, 5) + " " + unit + "\n";
    if (!plan.pattern_run) text += "reprojection: " + fixed(m.reprojection_rms, 4) + " px rms per axis\n";
    text += "mean surface height over the " + std::string(plan.pattern_run ? "region" : "pattern") + ": " +
            fixed(m.height_mm, 4) + " mm\n";
  }
  text += "time: " + fixed(1000 * m.seconds_a_frame, 2) + " ms a frame\n";
  for (const std::string& warning : warnings) text += "warning: " + warning + "\n";
  text += "\nframe\tfile\tstatus\t" + std::string(plan.pattern_run ? "pixels" : "corners") + "\tmean error (" + unit +
          ")\theight (mm)";
  text += plan.options.free_index ? "\tindex\tits deviation\n" : "\n";
  for (const FrameRecord& frame : result.frames) {
    text += std::to_string(frame.sequence) + "\t" + frame.name + "\t" + to_string(frame.status) + "\t" +
            std::to_string(frame.found) + "/" + std::to_string(frame.expected);
    if (frame.has_surface())
      text += "\t" + fixed(frame.estimate.mean_error, 5) + "\t" + fixed(pattern_height(plan, frame.estimate.coefficients), 4);
    if (frame.has_surface() && plan.options.free_index)
      text += "\t" + fixed(frame.estimate.index, 6) + "\t" + fixed(frame.estimate.index_deviation, 6);
    text += "\n";
  }
  return text;
}

Outcome<void> write_series(const std::filesystem::path& series, const std::filesystem::path& summary, const RunPlan& plan,
                           const RunResult& result, const std::vector<std::string>& head,
                           const std::vector<std::string>& warnings) {
  std::vector<std::string> all = warnings;
  all.insert(all.end(), result.warnings.begin(), result.warnings.end());
  if (auto done = write_text_file(series, series_csv(plan, result)); !done) return done.error();
  if (auto done = write_text_file(model_file_path(series), series_model(plan, result)); !done) return done.error();
  return write_text_file(summary, summary_text(plan, result, head, all));
}

}  // namespace srd::host
