// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/outputs.hpp"

#include <algorithm>

#include "drivers/geometry/calibration.hpp"
#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "host/bundle/lens.hpp"
#include "host/calibrate/figures.hpp"
#include "host/plot/page.hpp"
#include "host/plot/png.hpp"
#include "host/plot/svg.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;

std::string value_words(double value, double error) { return formatted("%.6g \xc2\xb1 %.2g", value, error); }

std::vector<std::pair<std::string, std::string>> facts_of(const CalibrationResult& result) {
  const bundle::CameraFit& fit = result.fit;
  const Coverage& coverage = result.coverage;
  std::vector<std::pair<std::string, std::string>> facts;
  facts.emplace_back("Images", formatted("%zu of %d x %d px", result.views.size(), result.width, result.height));
  facts.emplace_back("Board", formatted("%d x %d inner corners, squares of %g mm", result.board.columns, result.board.rows,
                                        result.board.square_mm));
  facts.emplace_back("Residuals",
                     formatted("%.3f px rms per axis, %d corners, %d left out", fit.rms_px, fit.used, fit.rejected));
  facts.emplace_back("Coverage", formatted("%.0f %% of the image, boards tilted by %.0f to %.0f degrees, %.0f to %.0f mm away",
                                           100 * coverage.image_part, coverage.least_tilt, coverage.most_tilt, coverage.near_mm,
                                           coverage.far_mm));
  if (result.check.even)
    facts.emplace_back("Halves", formatted("%s (chi-square %.1f; chance stays below %.1f)",
                                           result.check.halves_agree() ? "agree" : "contradict each other", result.check.halves,
                                           result.check.halves_limit));
  facts.emplace_back("Next view", result.next.place + ", " + result.next.attitude +
                                      formatted("; parameters' errors shrink by %.0f %% on average", 100 * result.next.gain));
  return facts;
}

PageTable parameter_table(const CalibrationResult& result) {
  const bundle::CameraFit& fit = result.fit;
  PageTable table{"Parameters and their standard errors (1 sigma); px, distortion without unit.",
                  {"", "value", "even views", "odd views"},
                  {}};
  const auto half = [&](const std::optional<bundle::CameraFit>& of, int i) {
    return of ? value_words(of->intrinsics[static_cast<std::size_t>(i)], of->deviation(i)) : std::string();
  };
  for (int i = 0; i < fit.lens_size(); ++i)
    table.rows.push_back({bundle::intrinsic_name(i), value_words(fit.intrinsics[static_cast<std::size_t>(i)], fit.deviation(i)),
                          half(result.check.even, i), half(result.check.odd, i)});
  if (fit.surface == bundle::Surface::kBent)
    for (int i = 0; i < bundle::kBend; ++i) {
      const auto bend = [&](const bundle::CameraFit& of) { return value_words(of.bend[i], of.deviation(of.board_at() + i)); };
      table.rows.push_back({i == 0 ? "bend along rows, mm" : "bend along columns, mm", bend(fit),
                            result.check.even ? bend(*result.check.even) : "",
                            result.check.odd ? bend(*result.check.odd) : ""});
    }
  return table;
}

PageTable projection_table(const CalibrationResult& result) {
  PageTable table{"Deviation of where a point is seen, px, at three distances.",
                  {"", "middle of the image", "its first pixel", "its last pixel"},
                  {}};
  for (const auto& map : result.maps)
    table.rows.push_back({formatted("%.0f mm", map.distance_mm), formatted("%.3f", map.at(map.rows / 2, map.columns / 2)),
                          formatted("%.3f", map.at(0, 0)), formatted("%.3f", map.at(map.rows - 1, map.columns - 1))});
  return table;
}

PageTable view_table(const CalibrationResult& result) {
  PageTable table{"Views. Contradiction: 1 where a view agrees with the others as well as its corners' noise lets it.",
                  {"", "corners", "left out", "rms, px", "share, %", "contradiction"},
                  {}};
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const bundle::ViewFit& view = result.fit.views[i];
    table.rows.push_back({result.views[i].name, std::to_string(view.used.size()),
                          std::to_string(std::count(view.used.begin(), view.used.end(), char{0})),
                          formatted("%.3f", view.rms_px), formatted("%.1f", 100 * view.share),
                          formatted("%.1f", view.contradiction)});
  }
  return table;
}

PageTable outlier_table(const CalibrationResult& result) {
  PageTable table{"Corners left out.", {"", "row", "column", "u, px", "v, px", "off by, px"}, {}};
  for (std::size_t v = 0; v < result.views.size(); ++v)
    for (std::size_t c = 0; c < result.views[v].corners.size(); ++c) {
      if (result.fit.views[v].used[c] != 0) continue;
      const auto& corner = result.views[v].corners[c];
      table.rows.push_back({result.views[v].name, std::to_string(corner.row), std::to_string(corner.column),
                            formatted("%.2f", corner.pixel.x()), formatted("%.2f", corner.pixel.y()),
                            formatted("%.2f", result.fit.views[v].residuals[c].norm())});
    }
  return table;
}

Outcome<void> add_figure(Page& page, const Figure& figure, const fs::path& png) {
  auto svg = svg_element(figure.scene, figure.caption);
  if (!svg) return svg.error();
  page.figures.push_back({std::move(*svg), figure.caption});
  return write_png(figure.scene, png);
}

}  // namespace

CalibrationFiles calibration_files(const fs::path& out, const std::string& calibration_name) {
  return {out / calibration_name, out / "report.toml", out / "corners.csv", out / "uncertainty.csv", out / "calibration.html"};
}

Outcome<void> prepare_folder(const fs::path& out, const CalibrationFiles& files, bool force) {
  std::error_code error;
  if (!force)
    for (const fs::path& file : {files.calibration, files.report, files.corners, files.uncertainty, files.page})
      if (fs::exists(file, error))
        return Problem{Exit::kUsage,
                       "is there already",
                       file.string(),
                       "an --out folder without results",
                       "",
                       "give another --out, or --force to replace the results"};
  fs::create_directories(out, error);
  if (error)
    return Problem{Exit::kUsage,    "cannot be made",    out.string(), "a folder that can be written",
                   error.message(), "give another --out"};
  // Before minutes of work, not after.
  const fs::path probe = out / ".written";
  if (auto written = write_text_file(probe, ""); !written)
    return Problem{Exit::kUsage, "cannot be written", out.string(), "a folder that can be written", "", "give another --out"};
  fs::remove(probe, error);
  return {};
}

Outcome<void> write_results(const fs::path& out, const CalibrationFiles& files, const CalibrationResult& result) {
  const bundle::CameraFit& fit = result.fit;
  const std::vector<double>& k = fit.intrinsics;
  Calibration calibration;
  calibration.distortion.assign(k.begin() + bundle::kPinhole, k.end());
  calibration.camera = dsp::CameraModel<double>::make(k[0], k[1], k[2], k[3], calibration.distortion).value();
  calibration.image_width = result.width;
  calibration.image_height = result.height;
  calibration.covariance = dsp::IntrinsicsMatrix::Zero();
  calibration.covariance->topLeftCorner(fit.lens_size(), fit.lens_size()) =
      fit.covariance.topLeftCorner(fit.lens_size(), fit.lens_size());
  calibration.date = today();
  if (auto done = write_calibration(files.calibration, calibration); !done) return done;
  if (auto done = write_text_file(files.report, report_toml(result)); !done) return done;
  if (auto done = write_text_file(files.corners, corners_csv(result)); !done) return done;
  if (auto done = write_text_file(files.uncertainty, uncertainty_csv(result)); !done) return done;

  Page page{"Camera calibration", facts_of(result), result.warnings, {}, {}};
  if (auto done = add_figure(page, uncertainty_figure(result), out / "uncertainty.png"); !done) return done;
  if (auto done = add_figure(page, residual_figure(result), out / "residuals.png"); !done) return done;
  if (auto done = add_figure(page, views_figure(result), out / "views.png"); !done) return done;
  std::error_code error;
  fs::create_directories(out / "corners", error);
  std::size_t worst = 0;
  for (std::size_t i = 0; i < result.views.size(); ++i)
    if (fit.views[i].rms_px > fit.views[worst].rms_px) worst = i;
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const auto image = read_gray_image(result.sighted[i].file);
    if (!image) return image.error();
    const Figure figure = corners_figure(result, i, *image);
    const fs::path png = out / "corners" / (result.sighted[i].file.stem().string() + ".png");
    if (i != worst) {
      if (auto done = write_png(figure.scene, png); !done) return done;
      continue;
    }
    // The page carries the worst one only.
    if (auto done = add_figure(page, figure, png); !done) return done;
    if (auto done = write_gray_image(out / "undistorted.png", undistorted(*image, fit).view(), 3); !done) return done;
  }
  page.tables = {parameter_table(result), projection_table(result), view_table(result)};
  if (fit.rejected > 0) page.tables.push_back(outlier_table(result));
  return write_text_file(files.page, page_html(page));
}

}  // namespace srd::host
