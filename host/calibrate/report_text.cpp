// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "host/bundle/lens.hpp"
#include "host/calibrate/outputs.hpp"

namespace srd::host {

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

std::string line(const char* key, double value) {
  return std::string(key) + " = " + (std::isfinite(value) ? number_text(value) : "nan") + "\n";
}

const char* surface_name(bundle::Surface surface) {
  switch (surface) {
    case bundle::Surface::kFlat: return "flat";
    case bundle::Surface::kBent: return "bent";
    case bundle::Surface::kFree: return "free";
  }
  return "";
}

}  // namespace

std::string report_toml(const CalibrationResult& result) {
  const bundle::CameraFit& fit = result.fit;
  std::string text = "# Written by srd calibrate beside the calibration: standard errors (1 sigma), checks and provenance.\n\n";
  text += "image_width = " + std::to_string(result.width) + "\nimage_height = " + std::to_string(result.height) + "\n";
  text += line("rms_px", fit.rms_px) + "corners_used = " + std::to_string(fit.used) +
          "\ncorners_left_out = " + std::to_string(fit.rejected) + "\n";
  text += line("added_px", fit.added_px) + line("stated_ratio", fit.stated_ratio) +
          line("variance_factor", fit.variance_factor) + line("view_factor", fit.view_factor) +
          "views_contradict = " + (fit.views_contradict ? "true" : "false") + "\n";
  text += std::string("model_fits = ") + (result.check.fits ? "true" : "false") + "\n";
  text += "remarks = [\n";
  for (const std::string& warning : result.warnings) text += "  " + quoted(warning) + ",\n";
  text += "]\n\n# Value and standard error; px, rad, or without unit.\n[parameters]\n";
  for (int i = 0; i < fit.lens_size(); ++i)
    text += bundle::intrinsic_name(i) + " = [" + number_text(fit.intrinsics[static_cast<std::size_t>(i)]) + ", " +
            number_text(fit.deviation(i)) + "]\n";
  text += "\n[board]\nrows = " + std::to_string(result.board.rows) + "\ncolumns = " + std::to_string(result.board.columns) +
          "\n" + line("square_mm", result.board.square_mm) + "surface = " + quoted(surface_name(fit.surface)) + "\n";
  if (fit.surface == bundle::Surface::kBent) {
    text += "# How far the middle stands out towards the camera from the ends, mm, and its standard error.\n";
    for (int i = 0; i < bundle::kBend; ++i)
      text += std::string(i == 0 ? "bend_along_rows_mm" : "bend_along_columns_mm") + " = [" + number_text(fit.bend[i]) + ", " +
              number_text(fit.deviation(fit.board_at() + i)) + "]\n";
  }
  if (fit.surface == bundle::Surface::kFree) {
    text += "# x, y, z of each corner, row by row, mm.\npoints_mm = [\n";
    for (const Eigen::Vector3d& p : fit.points)
      text += "  [" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + "],\n";
    text += "]\n";
  }
  text += "\n[checks]\n";
  if (result.check.even)
    text += "# Every second view against the others: chi-square of lens and bend, and what chance exceeds once in 1000.\n" +
            line("halves_chi_square", result.check.halves) + line("halves_limit", result.check.halves_limit);
  if (fit.surface == bundle::Surface::kFlat)
    text +=
        line("missing_bend_chi_square", result.check.bend_significance) + line("missing_bend_limit", result.check.bend_limit);
  text += line("image_covered", result.coverage.image_part) + line("least_tilt_degrees", result.coverage.least_tilt) +
          line("most_tilt_degrees", result.coverage.most_tilt) + line("nearest_mm", result.coverage.near_mm) +
          line("farthest_mm", result.coverage.far_mm);
  text += "next_view = " + quoted(result.next.place + ", " + result.next.attitude) + "\n";
  if (result.check.even)
    for (const auto& [name, half] : {std::pair{"even", &*result.check.even}, std::pair{"odd", &*result.check.odd}}) {
      text += std::string("\n[checks.") + name + "]\n" + line("rms_px", half->rms_px);
      for (int i = 0; i < half->lens_size(); ++i)
        text += bundle::intrinsic_name(i) + " = [" + number_text(half->intrinsics[static_cast<std::size_t>(i)]) + ", " +
                number_text(half->deviation(i)) + "]\n";
    }
  for (const bundle::UncertaintyMap& map : result.maps) {
    const auto centre = map.at(map.rows / 2, map.columns / 2), corner = map.at(0, 0);
    text += "\n[[projection]]\n" + line("distance_mm", map.distance_mm) + line("middle_px", centre) +
            line("first_corner_px", corner);
  }
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const bundle::ViewFit& view = fit.views[i];
    std::size_t left_out = 0;
    for (const char used : view.used) left_out += used == 0 ? 1U : 0U;
    text += "\n[[views]]\nimage = " + quoted(result.sighted[i].file.string()) +
            "\ncorners = " + std::to_string(view.used.size()) + "\nleft_out = " + std::to_string(left_out) +
            "\nthreshold = " + std::to_string(result.sighted[i].threshold) + "\n" + line("rms_px", view.rms_px) +
            line("share", view.share) + line("contradiction", view.contradiction);
    text += "turn_rad = [" + number_text(view.pose[0]) + ", " + number_text(view.pose[1]) + ", " + number_text(view.pose[2]) +
            "]\ntranslation_mm = [" + number_text(view.pose[3]) + ", " + number_text(view.pose[4]) + ", " +
            number_text(view.pose[5]) + "]\n";
  }
  return text;
}

std::string corners_csv(const CalibrationResult& result) {
  std::string text = "image,row,column,u,v,sigma,residual_u,residual_v,used\n";
  for (std::size_t v = 0; v < result.views.size(); ++v)
    for (std::size_t c = 0; c < result.views[v].corners.size(); ++c) {
      const auto& corner = result.views[v].corners[c];
      const auto& residual = result.fit.views[v].residuals[c];
      std::string name = result.views[v].name;
      for (char& letter : name)
        if (letter == ',' || letter == '"') letter = '_';
      text += name + "," + std::to_string(corner.row) + "," + std::to_string(corner.column) +
              formatted(",%.5f,%.5f,%.5f,%.5f,%.5f,%d\n", corner.pixel.x(), corner.pixel.y(), corner.sigma, residual.x(),
                        residual.y(), result.fit.views[v].used[c] != 0 ? 1 : 0);
    }
  return text;
}

std::string uncertainty_csv(const CalibrationResult& result) {
  std::string text = "distance_mm,u,v,deviation_px\n";
  for (const bundle::UncertaintyMap& map : result.maps)
    for (int row = 0; row < map.rows; ++row)
      for (int column = 0; column < map.columns; ++column)
        text += formatted("%.3f,%.3f,%.3f,%.6g\n", map.distance_mm, map.u(column, result.width), map.v(row, result.height),
                          map.at(row, column));
  return text;
}

}  // namespace srd::host
