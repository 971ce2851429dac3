// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/command.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "drivers/support/text_file.hpp"
#include "host/bundle/lens.hpp"
#include "host/calibrate/outputs.hpp"
#include "host/run/option_checks.hpp"

namespace srd::host {

namespace {

CLI::Validator above_zero(const std::string& unit) {
  return CLI::Validator(
      [unit](const std::string& text) -> std::string {
        const auto x = parse_number<double>(text);
        return x && *x > 0 && *x < 1e6 ? std::string() : "'" + text + "' is not a number above 0, " + unit;
      },
      "", "above_zero");
}

void show_progress(std::size_t done, std::size_t of) {
  std::fprintf(stderr, "\rimage %zu of %zu%s", done, of, done == of ? "\n" : "");
  std::fflush(stderr);
}

void print_summary(const CalibrationResult& result, const std::filesystem::path& out) {
  const bundle::CameraFit& fit = result.fit;
  std::printf("%zu views, %d corners, %d left out, %.4f px rms per axis\n", result.views.size(), fit.used, fit.rejected,
              fit.rms_px);
  for (int i = 0; i < fit.lens_size(); ++i)
    std::printf("%-3s %12.6g +- %.2g\n", bundle::intrinsic_name(i).c_str(), fit.intrinsics[static_cast<std::size_t>(i)],
                fit.deviation(i));
  if (fit.surface == bundle::Surface::kBent)
    std::printf("bend of the board, mm: %+.4f +- %.4f along its rows' numbers, %+.4f +- %.4f along its columns'\n",
                fit.bend.x(), fit.deviation(fit.board_at()), fit.bend.y(), fit.deviation(fit.board_at() + 1));
  if (result.check.even)
    std::printf("halves of the views %s: fx %.2f +- %.2f and %.2f +- %.2f, cx %.1f +- %.1f and %.1f +- %.1f\n",
                result.check.halves_agree() ? "agree" : "contradict each other", result.check.even->intrinsics[0],
                result.check.even->deviation(0), result.check.odd->intrinsics[0], result.check.odd->deviation(0),
                result.check.even->intrinsics[2], result.check.even->deviation(2), result.check.odd->intrinsics[2],
                result.check.odd->deviation(2));
  const bundle::UncertaintyMap& map = result.maps.front();
  std::printf("a point at %.0f mm is seen where it is within %.2g px in the image's middle, %.2g px at its first pixel\n",
              map.distance_mm, map.at(map.rows / 2, map.columns / 2), map.at(0, 0));
  std::printf("next view that would tell most: %s, %s\n", result.next.place.c_str(), result.next.attitude.c_str());
  std::printf("results in %s\n", out.string().c_str());
}

Outcome<void> run_calibrate(const CalibrateOptions& options) {
  auto plan = plan_calibration(options);
  if (!plan) return plan.error();
  const CalibrationFiles files = calibration_files(options.out, plan->calibration_name);
  if (auto free = prepare_folder(options.out, files, options.force); !free) return free;
  auto result = calibrate(*plan, isatty(STDERR_FILENO) != 0 ? show_progress : nullptr);
  if (!result) return result.error();
  result->warnings.insert(result->warnings.end(), plan->warnings.begin(), plan->warnings.end());
  for (const std::string& warning : result->warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  if (auto done = write_results(options.out, files, *result); !done) return done;
  print_summary(*result, options.out);
  return {};
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command =
      app.add_subcommand("calibrate", "Lens of a camera from images of a checkerboard, every number with its error");
  command
      ->add_option("sources", options->sources,
                   "Images, folders of images, or one OpenSRD settings file (.xml) of a calibration")
      ->required();
  command->add_option("--out", options->out, "Folder for the results; made when it is not there")->required();
  command->add_flag("--force", options->force, "Replace results that are there already");
  command->add_option("--board", options->board, "Inner corners along and across the board, as 17x7 (default: the settings')");
  command->add_option("--square-mm", options->square, "Side of a square, mm (default: the settings')")->check(above_zero("mm"));
  takes_one_of(command->add_option("--coefficients", options->camera.coefficients,
                                   "Of the distortion: 4, 5, 8 (rational), 12 (thin prism) or 14 (tilted sensor)"),
               {4, 5, 8, 12, 14})
      ->default_str("5");
  const std::vector<std::pair<std::string, bundle::Surface>> surfaces = {
      {"flat", bundle::Surface::kFlat}, {"bent", bundle::Surface::kBent}, {"free", bundle::Surface::kFree}};
  takes_one_of(command->add_option(
                   "--surface", options->camera.surface,
                   "Of the board: flat, bent (two numbers are estimated) or free (every corner of its own; 15 views or more)"),
               surfaces)
      ->default_str("bent");
  command
      ->add_option("--threshold", options->search.threshold,
                   "Least response of a corner (default: what each image's own noise does not reach)")
      ->check(CLI::Range(1, 2040));
  takes_one_of(command->add_option("--radius", options->search.radius, "Of the corner detector, px: 5 or 10"), {5, 10})
      ->default_str("5");
  command->callback([options, &exit_code] {
    const Outcome<void> done = run_calibrate(*options);
    exit_code = static_cast<int>(done ? Exit::kDone : done.error().exit);
    if (!done) std::fputs(done.error().text().c_str(), stderr);
  });
}

}  // namespace srd::host
