// SPDX-License-Identifier: Apache-2.0
#include "host/run/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/support/text_file.hpp"
#include "host/coefficients/columns.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/run/found_index.hpp"

namespace srd::host {

namespace {

constexpr const char* kNode = "reconstruct";

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "";
  std::array<char, 400> buffer;
  const int length = std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

PatternExtent extent(const Points& points) {
  PatternExtent e{points[0].x(), points[0].x(), points[0].y(), points[0].y()};
  for (const auto& p : points) {
    e.x_min = std::min(e.x_min, p.x());
    e.x_max = std::max(e.x_max, p.x());
    e.y_min = std::min(e.y_min, p.y());
    e.y_max = std::max(e.y_max, p.y());
  }
  return e;
}

std::string mode_names(const dsp::ModeList& modes) {
  std::string names;
  for (const dsp::Mode& mode : modes) names += (names.empty() ? "" : " ") + std::string(mode.name().data());
  return names;
}

}  // namespace

const char* metric_name(const RunPlan& plan) {
  if (plan.pattern_run) return "pattern";
  switch (plan.options.metric) {
    case dsp::Metric::kReprojection: return "reprojection";
    case dsp::Metric::kDisparity: return "disparity";
    case dsp::Metric::kCollinearity: return "collinearity";
  }
  return "unknown";
}

const char* metric_unit(const RunPlan& plan) {
  if (plan.pattern_run) return "grey levels";
  switch (plan.options.metric) {
    case dsp::Metric::kReprojection: return "px";
    case dsp::Metric::kDisparity: return "mm";
    case dsp::Metric::kCollinearity: return "rad";
  }
  return "";
}

std::string series_csv(const RunPlan& plan, const RunResult& result) {
  std::string text = coefficient_header(plan.model.modes);
  const char* clock = plan.times_known ? "recording" : "unknown";
  const PatternExtent pattern = extent(plan.points);
  for (const FrameRecord& frame : result.frames) {
    const bool good = frame.has_surface();
    const dsp::Estimate<double>& e = frame.estimate;
    text += std::string(kNode) + "," + boot_text(0) + "," + std::to_string(frame.sequence) + "," +
            std::to_string(frame.time_ns) + "," + clock + "," + frame.status + "," + std::to_string(frame.expected) + "," +
            std::to_string(frame.found) + "," + std::to_string(good ? e.corners_used : 0) + "," +
            (good ? fixed(e.mean_error, 7) : "") + "," + metric_name(plan) + "," +
            (good ? fixed(plan.model.height(e.coefficients, pattern.x_centre(), pattern.y_centre()), 6) : "");
    for (int j = 0; j < plan.model.modes.size(); ++j) text += "," + (good ? fixed(e.coefficients[j], 6) : "");
    for (int j = 0; j < plan.model.modes.size(); ++j)
      text += "," + (good && j < e.standard_deviation.size() ? fixed(e.standard_deviation[j], 6) : "");
    text += ",,\n";  // no wall time
  }
  return text;
}

std::string series_model(const RunPlan& plan, const RunResult& result) {
  return model_file_text({{{kNode, plan.model, index_of(plan, result), extent(plan.points), plates_of(plan.media)}}});
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
  text += "surface: " + mode_names(plan.model.modes) + ", Lx " + number_text(plan.model.lx) + " mm, Ly " +
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
    text += std::to_string(frame.sequence) + "\t" + frame.name + "\t" + frame.status + "\t" + std::to_string(frame.found) +
            "/" + std::to_string(frame.expected);
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
