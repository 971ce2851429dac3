// SPDX-License-Identifier: Apache-2.0
#include "host/study/study.hpp"

#include <cstdarg>
#include <cstdio>

#include "drivers/support/text_file.hpp"
#include "host/plot/page.hpp"
#include "host/plot/png.hpp"
#include "host/plot/svg.hpp"
#include "host/study/study_figures.hpp"

namespace srd::study {

namespace {

namespace fs = std::filesystem;

[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  (void)std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string corner_csv(const std::vector<CornerRow>& rows) {
  std::string text =
      "varied,blur_px,noise,contrast,square_px,corners,found,rms_px,stated_px,bound_px,opencv_px,opencv_window\n";
  for (const CornerRow& row : rows) {
    const CornerConditions& c = row.conditions;
    text += row.varied + formatted(",%g,%g,%g,%g,%d,%d,%.5f,%.5f,%.5f,%.5f,%d\n", c.blur_px, c.noise, c.contrast, c.square_px,
                                   row.corners, row.found, row.rms_px, row.stated_px, row.bound_px, row.opencv_px,
                                   row.opencv_window);
  }
  return text;
}

const char* name_of(SurfaceSource source) { return source == SurfaceSource::kFeatures ? "features" : "images"; }

std::string surface_csv(const std::vector<SurfaceRow>& rows) {
  std::string text = "source,parameters,cameras,draws,surfaces,corner_px,surface_mm,bound_mm\n";
  for (const SurfaceRow& row : rows)
    text += formatted("%s,%d,%d,%d,%d,%.5f,%.6f,%.6f\n", name_of(row.source), row.parameters, row.cameras, row.draws,
                      row.surfaces, row.corner_px, row.surface_mm, row.bound_mm);
  return text;
}

host::PageTable corner_table(const std::vector<CornerRow>& rows) {
  host::PageTable table{"Corners, px rms per axis",
                        {"varied", "value", "found", "measured", "stated", "bound", "measured / bound", "cornerSubPix"},
                        {}};
  for (const CornerRow& row : rows)
    table.rows.push_back({row.varied, formatted("%g", row.value()), formatted("%d of %d", row.found, row.corners),
                          formatted("%.4f", row.rms_px), formatted("%.4f", row.stated_px), formatted("%.4f", row.bound_px),
                          formatted("%.2f", row.rms_px / row.bound_px),
                          formatted("%.4f (%d)", row.opencv_px, row.opencv_window)});
  return table;
}

host::PageTable surface_table(const std::vector<SurfaceRow>& rows) {
  host::PageTable table{"Surface over the pattern, mm rms",
                        {"from", "parameters", "cameras", "surfaces", "corner, px", "measured", "bound", "ratio"},
                        {}};
  for (const SurfaceRow& row : rows)
    table.rows.push_back({name_of(row.source), std::to_string(row.parameters), std::to_string(row.cameras),
                          formatted("%d of %d", row.surfaces, row.draws), formatted("%.4f", row.corner_px),
                          formatted("%.4f", row.surface_mm), formatted("%.4f", row.bound_mm),
                          formatted("%.2f", row.surface_mm / row.bound_mm)});
  return table;
}

}  // namespace

Outcome<std::vector<fs::path>> study(const StudyOptions& options) {
  const std::vector<fs::path> files{options.out / "study.html", options.out / "study-corners.png",
                                    options.out / "study-surface.png", options.out / "corners.csv",
                                    options.out / "surface.csv"};
  std::error_code error;
  if (!options.force)
    for (const fs::path& file : files)
      if (fs::exists(file, error))
        return Problem{
            Exit::kUsage, "the file is there already", file.string(), "", "", "another --out DIR, or --force to replace it"};
  error.clear();
  fs::create_directories(options.out, error);
  if (error)
    return Problem{Exit::kInput,    "the folder cannot be made", options.out.string(), "a folder that can be written",
                   error.message(), "another --out DIR"};
  auto corners = study_corners(options.quick, options.progress);
  if (!corners) return corners.error();
  auto surfaces = study_surfaces(options.quick, options.progress);
  if (!surfaces) return surfaces.error();

  const std::vector<host::Figure> figures{corner_figure(*corners), surface_figure(*surfaces)};
  host::Page page{"Accuracy on images with known truth", {}, {}, {}, {}};
  page.facts = {{"Scenes", "rendered by the simulator; every run of the same version gives the same numbers"}};
  if (options.quick) page.notes.emplace_back("A quick run: few conditions and draws, so the numbers scatter.");
  for (const host::Figure& figure : figures) {
    auto svg = host::svg_element(figure.scene, figure.caption);
    if (!svg) return svg.error();
    page.figures.push_back({std::move(*svg), figure.caption});
  }
  page.tables = {corner_table(*corners), surface_table(*surfaces)};

  if (auto done = write_text_file(files[0], host::page_html(page)); !done) return done.error();
  for (std::size_t i = 0; i < figures.size(); ++i)
    if (auto done = host::write_png(figures[i].scene, files[i + 1]); !done) return done.error();
  if (auto done = write_text_file(files[3], corner_csv(*corners)); !done) return done.error();
  if (auto done = write_text_file(files[4], surface_csv(*surfaces)); !done) return done.error();
  return files;
}

}  // namespace srd::study
