// SPDX-License-Identifier: Apache-2.0
#include "host/reconstruct/command.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "drivers/recording/image_file.hpp"
#include "drivers/recording/recording.hpp"
#include "drivers/support/text_file.hpp"
#include "host/reconstruct/options.hpp"
#include "host/run/option_checks.hpp"
#include "host/run/ordered_work.hpp"

namespace srd::host {

namespace {

Outcome<void> reconstruct(ReconstructOptions options, const std::vector<std::string>& plate_texts) {
  const dsp::EstimatorOptions bounds;
  if (options.free_index && options.refractive_index &&
      !(*options.refractive_index >= bounds.index_lower && *options.refractive_index <= bounds.index_upper))
    return Problem{Exit::kUsage,
                   "--refractive-index is outside the bounds of --free-index",
                   "",
                   "1.3 to 1.4",
                   number_text(*options.refractive_index),
                   "leave one of them out"};
  const Outcome<Plates> plates = parse_plates(plate_texts, "--plate");
  if (!plates) return plates.error();
  options.plates = *plates;
  std::error_code error;
  const auto status = std::filesystem::status(options.source, error);
  if (!std::filesystem::exists(status))
    return Problem{
        Exit::kInput, "no such file or folder", options.source.string(), "an OpenSRD settings.xml or the folder of a recording",
        "",           "check the path"};
  if (!std::filesystem::is_directory(status)) return reconstruct_settings(options);
  // A lab's OpenSRD folder has its settings in it.
  const std::filesystem::path settings = options.source / "settings.xml";
  if (!std::filesystem::exists(settings, error) || std::filesystem::exists(options.source / kCalibrationName, error))
    return reconstruct_recording(options);
  ReconstructOptions inside = options;
  inside.source = settings;
  return reconstruct_settings(inside);
}

}  // namespace

void add_reconstruct_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ReconstructOptions>();
  CLI::App* command = app.add_subcommand("reconstruct", "Water surfaces from an OpenSRD settings.xml or a recording");
  command->add_option("source", options->source, "OpenSRD settings.xml or its folder, or the folder of a recording")
      ->required();
  command->add_option("--out", options->out, "Folder for the results; made when it is not there")->required();
  command->add_flag("--force", options->force, "Replace results that are there already");
  command
      ->add_option("--refractive-index", options->refractive_index,
                   "Of the water, against air 1 (default: what is in the recording, else 1.336 for OpenSRD settings, 1.333 for "
                   "recordings)")
      ->check(within(1, 2, ""));
  auto plates = std::make_shared<std::vector<std::string>>();
  command
      ->add_option("--plate", *plates,
                   "THICKNESS,INDEX of a transparent plate on the pattern, mm; again for each further one, from the top down; "
                   "an air gap has index 1 (default: what is in the recording, else none)")
      ->expected(1)
      ->take_all();
  command->add_flag("--free-index", options->free_index,
                    "Estimate the index of the water too; refused where the view cannot tell it from the height");
  std::vector<std::pair<std::string, dsp::Metric>> metrics;
  for (const dsp::Metric metric : dsp::kMetrics) metrics.emplace_back(to_string(metric), metric);
  takes_one_of(command->add_option("--metric", options->metric, "What is minimised: reprojection, disparity or collinearity"),
               metrics);
  const std::vector<std::pair<std::string, dsp::Loss>> losses = {
      {"none", dsp::Loss::kNone}, {"huber", dsp::Loss::kHuber}, {"tukey", dsp::Loss::kTukey}};
  takes_one_of(command->add_option("--loss", options->loss,
                                   "How much a corner far from the others counts: none (as its deviation says, as published), "
                                   "huber (less), tukey (not at all)"),
               losses);
  command
      ->add_option("--threads", options->threads,
                   "Threads (default: as many as the machine runs at once); results do not depend on it")
      ->default_val(hardware_threads())
      ->check(CLI::Range(1, 256));
  command
      ->add_option("--rate", options->rate_hz,
                   "Frames a second: of images that carry no time; of a recording with frames.csv, times then follow from the "
                   "sequence and not from its clock")
      ->check(within(0, 1e6, "Hz"));
  command
      ->add_option("--bits", options->sample_bits,
                   "Bits of the images' samples where they take two bytes each and lie at the lower end (default: 16; in a PGM "
                   "those of its maximum)")
      ->check(CLI::Range(kMinSampleBits, kMaxSampleBits));
  const char* settings_only = "OpenSRD settings";
  command->add_option("--features", options->features, "Features of an earlier run (its --out folder) instead of images")
      ->group(settings_only);
  const char* recordings_only = "Recordings";
  const std::vector<std::pair<std::string, int>> models = {{"1", 1},   {"3", 3},     {"5", 5},           {"8", 8},
                                                           {"12", 12}, {"plane", 3}, {"level-normal", 2}};
  CLI::Option* model =
      takes_one_of(command->add_option(
                       "--model", options->model,
                       "Parameters of the surface: 1, 3 (plane), 5, 8 or 12 (default: the recording's, else 5); with settings "
                       "of OpenSRD's 2017 release also level-normal, its form with 2 parameters"),
                   models);
  command->add_option("--modes", options->modes, "Modes of the surface instead: A00,B,C,A10,..")
      ->delimiter(',')
      ->excludes(model)
      ->group(recordings_only);
  command->add_option("--lx", options->lx, "Length scale along X, mm")->check(within(0, 1e6, "mm"))->group(recordings_only);
  command->add_option("--ly", options->ly, "Length scale along Y, mm")->check(within(0, 1e6, "mm"))->group(recordings_only);
  command->add_option("--guess", options->guess, "Surface to start from, mm: depth, or depth and further coefficients")
      ->delimiter(',')
      ->check(within(-1e6, 1e6, "mm"))
      ->group(recordings_only);
  command->callback([options, plates, &exit_code] {
    const Outcome<void> done = reconstruct(*options, *plates);
    exit_code = static_cast<int>(done ? Exit::kDone : done.error().exit);
    if (!done) std::fputs(done.error().text().c_str(), stderr);
  });
}

}  // namespace srd::host
