// SPDX-License-Identifier: Apache-2.0
#include "host/pose/pose_files.hpp"

#include <cmath>

#include "drivers/geometry/pose.hpp"
#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "host/plot/page.hpp"
#include "host/plot/png.hpp"
#include "host/plot/svg.hpp"
#include "host/pose/pose_picture.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;
using dsp::Vec3;

constexpr double kDegrees = 180 / M_PI;

std::string list_of(const Vec3<double>& v) {
  return "[" + formatted("%.9g", v.x()) + ", " + formatted("%.9g", v.y()) + ", " + formatted("%.9g", v.z()) + "]";
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

double rms_mm(const std::vector<dsp::Vec2<double>>& left) {
  double sum = 0;
  for (const auto& v : left) sum += v.squaredNorm() / static_cast<double>(2 * left.size());
  return std::sqrt(sum);
}

// Of the points along X and Y, rms.
double print_deviation(const PointRefinement& print) {
  double sum = 0;
  for (const auto& d : print.deviation) sum += d.head<2>().squaredNorm() / static_cast<double>(2 * print.deviation.size());
  return std::sqrt(sum);
}

std::string report_toml(const PoseResult& result, const std::vector<dsp::Vec2<double>>& left_mm) {
  const MeasuredPose& pose = result.pose;
  const PoseDeviations sd = deviations_of(pose.fit.pose, pose.covariance);
  std::string text =
      "# Lengths mm, angles rad, image coordinates px; every deviation is one standard deviation.\n[reference]\nimages = [";
  for (std::size_t i = 0; i < result.references.size(); ++i) text += (i > 0 ? ", " : "") + quoted(result.references[i]);
  text += "]\ncalibration = " + quoted(result.calibration_file) + "\norder = " + quoted(pose.order.how) + "\n";
  text += formatted("corners = %d\nrows = %d\ncolumns = %d\n", pose.fit.corners, pose.board.rows, pose.board.columns) +
          "square_mm = " + number_text(pose.square_mm) + "\n";
  if (pose.view.scatter_factor > 0) text += formatted("image_variance_factor = %.4f\n", pose.view.scatter_factor);
  if (result.water.wet())
    text += "level_mm = " + number_text(*result.water.level_mm) +
            "\nlevel_deviation_mm = " + number_text(result.water.level_deviation_mm) +
            "\nrefractive_index = " + number_text(result.water.media.water) + "\n";
  text += "\n[pose]\n";
  text += "rotation = [" + list_of(pose.fit.pose.rotation.row(0)) + ", " + list_of(pose.fit.pose.rotation.row(1)) + ", " +
          list_of(pose.fit.pose.rotation.row(2)) + "]\n";
  text += "translation_mm = " + list_of(pose.fit.pose.translation) + "\ncentre_mm = " + list_of(pose.fit.pose.centre()) + "\n";
  text += "translation_deviation_mm = " + list_of(sd.translation) + "\ncentre_deviation_mm = " + list_of(sd.centre) +
          "\nturn_deviation_rad = " + list_of(sd.turn) + "  # about the camera's axes\n";
  text +=
      "# of (turn about the camera's x, y, z in rad; translation in mm): x_C = exp[turn] R X + T + translation\ncovariance = "
      "[\n";
  for (int row = 0; row < 6; ++row) {
    text += "  [";
    for (int column = 0; column < 6; ++column)
      text += (column > 0 ? ", " : "") + formatted("%.9e", pose.covariance(row, column));
    text += "],\n";
  }
  text += "]\n\n[residuals]\n";
  text += formatted(
      "rms_px = %.5f\nworst_px = %.5f\ncommon_px = %.5f\nvariance_factor = %.4f\nneighbour_correlation = %.3f\nrms_mm = %.5f\n",
      pose.fit.rms_px, pose.fit.worst_px, pose.fit.common_px, pose.fit.estimate.variance_factor, pose.neighbour_correlation,
      rms_mm(left_mm));
  if (result.print) {
    const PointRefinement& print = *result.print;
    text += "\n[print]  # the pattern's points from several views; points.txt has them\n";
    text += formatted("views = %d\noff_mm = %.5f\noff_z_mm = %.5f\ndeviation_mm = %.5f\n", print.views, print.print_mm,
                      print.print_z_mm, print_deviation(print));
    text += formatted("views_before_px = %.5f\nviews_after_px = %.5f\nvariance_factor = %.4f\n", print.before_px,
                      print.after_px, print.variance_factor);
  }
  for (const HeightEffect& effect : result.effects) {
    text += "\n[[systematic]]  # what the pose's errors are in every surface measured with it\n";
    text += "depth_mm = " + number_text(effect.depth_mm) + "\nlx_mm = " + number_text(effect.model.lx) +
            "\nly_mm = " + number_text(effect.model.ly) + "\n";
    text += formatted("height_deviation_mm = %.6f\n", effect.surface.height_deviation);
    for (int j = 0; j < effect.model.modes.size(); ++j)
      text += std::string(effect.model.modes[j].name().data()) + formatted(" = %.6f\n", effect.surface.deviation[j]);
  }
  if (!pose.warnings.empty()) text += "\n[notes]\nwarnings = [\n";
  for (const std::string& warning : pose.warnings) text += "  " + quoted(warning) + ",\n";
  if (!pose.warnings.empty()) text += "]\n";
  return text;
}

PageTable pose_table(const PoseResult& result) {
  const MeasuredPose& pose = result.pose;
  const PoseDeviations sd = deviations_of(pose.fit.pose, pose.covariance);
  const Vec3<double> t = pose.fit.pose.translation, c = pose.fit.pose.centre();
  PageTable table{"The pose and one standard deviation of each number", {"", "x", "y", "z"}, {}};
  const auto row = [&](const char* name, const char* format, const Vec3<double>& v) {
    table.rows.push_back({name, formatted(format, v.x()), formatted(format, v.y()), formatted(format, v.z())});
  };
  row("translation, mm", "%.4f", t);
  row("deviation, mm", "%.4f", sd.translation);
  row("camera's centre in the world, mm", "%.4f", c);
  row("deviation, mm", "%.4f", sd.centre);
  row("turn about the camera's axes: deviation, degrees", "%.6f", sd.turn * kDegrees);
  return table;
}

PageTable effect_table(const PoseResult& result) {
  const dsp::ModeList& modes = result.effects.front().model.modes;
  PageTable table{
      "Systematic deviation that the pose's errors leave in every surface, mm", {"still water, mm", "height, rms"}, {}};
  for (const dsp::Mode& mode : modes) table.header.emplace_back(mode.name().data());
  for (const HeightEffect& effect : result.effects) {
    std::vector<std::string> row = {number_text(effect.depth_mm), formatted("%.4f", effect.surface.height_deviation)};
    for (int j = 0; j < modes.size(); ++j) row.push_back(formatted("%.4f", effect.surface.deviation[j]));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::vector<fs::path> pose_files(const fs::path& out) {
  return {out / "pose.yml",    out / "points.txt",    out / "report.toml",
          out / "overlay.png", out / "residuals.png", out / "pose.html"};
}

Outcome<void> write_pose_files(PoseResult& result, const fs::path& out) {
  std::error_code error;
  fs::create_directories(out, error);
  if (error)
    return Problem{Exit::kInput,    "the folder cannot be made", out.string(), "a folder that can be written",
                   error.message(), "another --out DIR"};
  const std::vector<fs::path> files = pose_files(out);
  const MeasuredPose& pose = result.pose;
  const std::vector<dsp::Vec2<double>> left_mm = left_on_pattern(pose, result.water.above());
  const Scene overlay = overlay_picture(pose, result.water.above()), map = residual_map(pose, left_mm);
  Page page{"Camera pose", {}, pose.warnings, {}, {}};
  page.facts = {
      {"Reference", result.references.size() == 1
                        ? result.references.front()
                        : formatted("%zu, the first ", result.references.size()) + result.references.front()},
      {"Calibration", result.calibration_file},
      {"Corners", formatted("%d, %.4f px rms left, %.4f px the worst", pose.fit.corners, pose.fit.rms_px, pose.fit.worst_px)},
      {"On the pattern", formatted("%.4f mm rms left an axis", rms_mm(left_mm))},
      {"Print and lens", formatted("%.4f px added to every corner's deviation; variance factor %.2f with it",
                                   pose.fit.common_px, pose.fit.estimate.variance_factor)},
      {"Order of the points", pose.order.how}};
  if (result.water.wet())
    page.facts.emplace_back("Seen through", formatted("still water of %g +- %g mm, index %g", *result.water.level_mm,
                                                      result.water.level_deviation_mm, result.water.media.water));
  if (result.print)
    page.facts.emplace_back("Print", formatted("%.4f mm an axis from the list, found to %.4f mm from %d views; ",
                                               result.print->print_mm, print_deviation(*result.print), result.print->views) +
                                         formatted("they leave %.4f px, with the list's points %.4f px", result.print->after_px,
                                                   result.print->before_px));
  std::vector<std::pair<const Scene*, std::string>> drawings = {
      {&overlay,
       "Corners over the reference image (blue), the world's axes, and what is left of each corner (orange), magnified."},
      {&map,
       "What is left of each corner on the pattern, magnified: arrows that agree with their neighbours are print or lens."}};
  std::vector<dsp::Vec2<double>> off;
  for (std::size_t i = 0; result.print && i < pose.order.points.size(); ++i) {
    const auto place = static_cast<std::size_t>(pose.order.points[i]);
    off.emplace_back((pose.points[place] - result.listed[place]).head<2>());
  }
  const std::optional<Scene> print_map = result.print ? std::optional(residual_map(pose, off)) : std::nullopt;
  if (print_map)
    drawings.emplace_back(&*print_map, "How far the print's corners lie from the list, found from all views, magnified.");
  for (const auto& [scene, caption] : drawings) {
    auto svg = svg_element(*scene, caption);
    if (!svg) return svg.error();
    page.figures.push_back({std::move(*svg), caption});
  }
  page.tables.push_back(pose_table(result));
  if (!result.effects.empty()) page.tables.push_back(effect_table(result));

  if (auto done = write_pose(files[0], pose.fit.pose, pose.errors()); !done) return done.error();
  if (auto done = write_points(files[1], pose.points); !done) return done.error();
  if (auto done = write_text_file(files[2], report_toml(result, left_mm)); !done) return done.error();
  if (auto done = write_png(overlay, files[3]); !done) return done.error();
  if (auto done = write_png(map, files[4]); !done) return done.error();
  return write_text_file(files[5], page_html(page));
}

std::string pose_summary(const PoseResult& result) {
  const MeasuredPose& pose = result.pose;
  const PoseDeviations sd = deviations_of(pose.fit.pose, pose.covariance);
  const Vec3<double> c = pose.fit.pose.centre(), t = pose.fit.pose.translation;
  std::string text =
      formatted("%d corners, order from ", pose.fit.corners) + pose.order.how +
      formatted("; %.4f px rms left an axis, of which print and lens %.4f px\n", pose.fit.rms_px, pose.fit.common_px);
  text += formatted("translation %.3f %.3f %.3f mm +- %.4f %.4f %.4f\n", t.x(), t.y(), t.z(), sd.translation.x(),
                    sd.translation.y(), sd.translation.z());
  text += formatted("centre %.3f %.3f %.3f mm +- %.4f %.4f %.4f, turn +- %.5f degrees\n", c.x(), c.y(), c.z(), sd.centre.x(),
                    sd.centre.y(), sd.centre.z(), sd.turn.norm() * kDegrees);
  for (const HeightEffect& effect : result.effects)
    text +=
        formatted("at %g mm of water: systematic height deviation %.4f mm\n", effect.depth_mm, effect.surface.height_deviation);
  return text;
}

}  // namespace srd::host
