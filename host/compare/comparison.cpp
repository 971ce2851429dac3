// SPDX-License-Identifier: Apache-2.0
#include "host/compare/comparison.hpp"

#include "drivers/support/mode_names.hpp"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <unordered_map>
#include <utility>

namespace srd::host {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;  // row of the run, row of the truth

Outcome<Pairs> match(const CoefficientRun& run, const Truth& truth, const std::string& truth_file, MatchBy by) {
  Pairs pairs;
  const std::string counts =
      std::to_string(run.rows.size()) + " estimated frames, " + std::to_string(truth.rows.size()) + " true ones";
  if (by == MatchBy::kOrder) {
    if (run.rows.size() != truth.rows.size())
      return Problem{.what = "frames cannot be matched by order",
                     .where = truth_file,
                     .expected = "as many rows as " + run.file,
                     .found = counts,
                     .advice = "match by time"};
    for (std::size_t i = 0; i < run.rows.size(); ++i) pairs.emplace_back(i, i);
    return pairs;
  }
  std::unordered_map<std::int64_t, std::size_t> row_at;
  for (std::size_t i = 0; i < truth.rows.size(); ++i)
    if (!row_at.emplace(truth.rows[i].time_ns, i).second)
      return Problem{.what = "time_ns " + std::to_string(truth.rows[i].time_ns) + " is there twice",
                     .where = truth_file,
                     .expected = "each time once",
                     .found = "",
                     .advice = "--by-order"};
  for (std::size_t i = 0; i < run.rows.size(); ++i)
    if (const auto found = row_at.find(run.rows[i].time_ns); found != row_at.end()) pairs.emplace_back(i, found->second);
  if (pairs.empty())
    return Problem{.what = "no time_ns of " + run.file + " is in the truth",
                   .where = truth_file,
                   .expected = "times equal to the last digit",
                   .found = counts,
                   .advice = "--by-order, when both files hold the same frames"};
  return pairs;
}

dsp::ModeList common_modes(const dsp::ModeList& a, const dsp::ModeList& b) {
  std::vector<dsp::Mode> modes;
  for (const dsp::Mode& mode : a)
    if (b.index_of(mode) >= 0) modes.push_back(mode);
  const auto list = dsp::ModeList::make(modes);
  return list ? *list : dsp::ModeList{};
}

ModeSummary summarise(const CoefficientRun& run, const Truth& truth, const Comparison& c, int mode) {
  const int at_run = run.modes.index_of(c.modes[mode]), at_truth = truth.modes.index_of(c.modes[mode]);
  const auto n = static_cast<double>(c.frames.size());
  ModeSummary s;
  double squares = 0, normalised = 0, scatter = 0, systematic = 0, true_mean = 0, true_squares = 0;
  for (const FrameError& frame : c.frames) {
    const double error = frame.mode[static_cast<std::size_t>(mode)];
    squares += error * error;
    s.mean += error / n;
    s.largest = std::max(s.largest, std::abs(error));
    const double ratio = error / run.rows[frame.row].standard_deviation[at_run];
    normalised += ratio * ratio;
    systematic += std::pow(run.rows[frame.row].systematic_deviation[at_run], 2);
    true_mean += truth.rows[frame.truth_row].coefficients[at_truth] / n;
  }
  for (const FrameError& frame : c.frames) {
    const double off = truth.rows[frame.truth_row].coefficients[at_truth] - true_mean;
    true_squares += off * off;
    scatter +=
        std::pow((frame.mode[static_cast<std::size_t>(mode)] - s.mean) / run.rows[frame.row].standard_deviation[at_run], 2);
  }
  s.rms = std::sqrt(squares / n);
  s.normalised = std::sqrt(normalised / n);
  s.scatter = std::sqrt(scatter / n);
  s.systematic = std::sqrt(systematic / n);
  s.true_spread = std::sqrt(true_squares / n);
  return s;
}

__attribute__((format(printf, 1, 2))) std::string formatted(const char* format, ...) {
  std::array<char, 256> buffer{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer.data(), buffer.size(), format, arguments);
  va_end(arguments);
  return buffer.data();
}

}  // namespace

Outcome<Comparison> compare(const CoefficientRun& run, const Truth& truth, const std::string& truth_file, MatchBy by,
                            const std::optional<RunGeometry>& geometry) {
  const auto pairs = match(run, truth, truth_file, by);
  if (!pairs) return pairs.error();
  Comparison c;
  c.modes = common_modes(run.modes, truth.modes);
  c.matched = pairs->size();
  if (c.modes.size() == 0)
    return Problem{.what = "shares no mode with " + run.file,
                   .where = truth_file + ":1",
                   .expected = "at least one of the estimated modes"};

  std::optional<SurfaceSampler> estimated, real, estimated_centre, real_centre;
  if (geometry) {
    dsp::SurfaceModel<double> true_model = geometry->model;
    true_model.modes = truth.modes;
    const std::vector<dsp::Vec2<double>> centre{{geometry->pattern.x_centre(), geometry->pattern.y_centre()}};
    estimated.emplace(geometry->model, geometry->places);
    estimated_centre.emplace(geometry->model, centre);
    real.emplace(true_model, geometry->places);
    real_centre.emplace(true_model, centre);
  }
  double height_squares = 0, surface_squares = 0;
  for (const auto& [row, truth_row] : *pairs) {
    const CoefficientRow& frame = run.rows[row];
    if (!frame.has_surface()) continue;
    const auto& a = truth.rows[truth_row].coefficients;
    FrameError error{.row = row, .truth_row = truth_row, .mode = {}, .height = kNaN, .surface_rms = kNaN};
    for (const dsp::Mode& mode : c.modes)
      error.mode.push_back(frame.coefficients[run.modes.index_of(mode)] - a[truth.modes.index_of(mode)]);
    if (geometry) {
      error.height = estimated_centre->heights(frame.coefficients)[0] - real_centre->heights(a)[0];
      const Eigen::VectorXd off = estimated->heights(frame.coefficients) - real->heights(a);
      error.surface_rms = std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
      if (c.frames.empty() || error.surface_rms > c.frames[c.worst].surface_rms) c.worst = c.frames.size();
    }
    height_squares += error.height * error.height;
    surface_squares += error.surface_rms * error.surface_rms;
    c.height_mean += error.height;
    c.frames.push_back(std::move(error));
  }
  if (c.frames.empty())
    return Problem{.what = "none of the frames with a true surface has an estimated one",
                   .where = run.file,
                   .expected = "at least one",
                   .found = std::to_string(c.matched) + " matched frames"};
  const auto n = static_cast<double>(c.frames.size());
  c.height_rms = std::sqrt(height_squares / n);
  c.height_mean /= n;
  for (const FrameError& frame : c.frames) c.height_systematic += std::pow(run.rows[frame.row].systematic_height, 2) / n;
  c.height_systematic = std::sqrt(c.height_systematic);
  c.surface_rms = std::sqrt(surface_squares / n);
  c.surface_largest = c.frames[c.worst].surface_rms;
  for (int j = 0; j < c.modes.size(); ++j) c.summary.push_back(summarise(run, truth, c, j));
  return c;
}

std::string comparison_text(const CoefficientRun& run, const Truth& truth, const Comparison& c,
                            const std::optional<RunGeometry>& geometry) {
  std::string out = "node " + run.node + ": " + std::to_string(c.matched) + " of " + std::to_string(run.rows.size()) +
                    " frames have a true surface (" + std::to_string(truth.rows.size()) + " given), " +
                    std::to_string(c.frames.size()) + " of them an estimated one\n";
  if (geometry) {
    const CoefficientRow& worst = run.rows[c.frames[c.worst].row];
    out +=
        formatted("surface over the pattern (%zu places): rms %.4f mm, worst frame %.4f mm (sequence %llu)\n",
                  geometry->places.size(), c.surface_rms, c.surface_largest, static_cast<unsigned long long>(worst.sequence));
    out += formatted("height at the pattern's centre: rms %.4f mm, mean error %+.4f mm\n", c.height_rms, c.height_mean);
    if (std::isfinite(c.height_systematic))
      out += formatted(
          "  of which errors of calibration and pose may leave %.4f mm (one standard deviation, alike in every frame)\n",
          c.height_systematic);
  } else {
    out +=
        "surface over the pattern: not known without the model's lengths and the pattern (--model, "
        "--points)\n";
  }
  out += "estimated minus true, mm\nmode        rms      mean   largest   rms/sd   true spread   systematic sd   scatter/sd\n";
  for (int j = 0; j < c.modes.size(); ++j) {
    const ModeSummary& s = c.summary[static_cast<std::size_t>(j)];
    const std::string ratio = std::isfinite(s.normalised) ? formatted("%8.2f", s.normalised) : "       -";
    const std::string systematic = std::isfinite(s.systematic) ? formatted("%15.4f", s.systematic) : "              -";
    const std::string scatter = std::isfinite(s.scatter) ? formatted("%12.2f", s.scatter) : "           -";
    out += formatted("%-5s %9.4f %+9.4f %9.4f %s %13.4f %s %s\n", c.modes[j].name().data(), s.rms, s.mean, s.largest,
                     ratio.c_str(), s.true_spread, systematic.c_str(), scatter.c_str());
  }
  for (const dsp::Mode& mode : run.modes)
    if (c.modes.index_of(mode) < 0) out += mode_name(mode) + ": not in the truth\n";
  for (const dsp::Mode& mode : truth.modes)
    if (c.modes.index_of(mode) < 0) out += mode_name(mode) + ": not estimated\n";
  return out;
}

}  // namespace srd::host
