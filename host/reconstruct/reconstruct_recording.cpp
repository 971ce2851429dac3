// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/recording/recording.hpp"
#include "drivers/support/text_file.hpp"
#include "dsp/pipeline/pattern.hpp"
#include "host/opensrd/results.hpp"
#include "host/reconstruct/options.hpp"
#include "host/run/report.hpp"
#include "host/run/series.hpp"

namespace srd::host {

namespace {

constexpr double kFreshWaterIndex = 1.333;  // optics (21): 20 C, 589 nm
constexpr int kDefaultParameters = 5;

// The water and the plates that count, and for a person where they come from.
struct Optics {
  dsp::Media<double> media;
  std::optional<dsp::SurfaceModel<double>> model;
  std::vector<std::string> head, warnings;
};

// The command line goes before the recording; where the two contradict, that is told.
Outcome<Optics> optics_of(const ReconstructOptions& options, const std::filesystem::path& folder) {
  const auto recorded = read_recorded_optics(folder);
  if (!recorded) return recorded.error();
  Optics optics;
  const std::string name{kOpticsName};
  std::string index_from = "the default", plates_from = "the default: the recording has no " + name;
  optics.media.water = kFreshWaterIndex;
  if (*recorded) {
    optics.media = (*recorded)->media;
    optics.model = (*recorded)->model;
    index_from = plates_from = name + " of the recording";
  }
  const auto contradicts = [&](const std::string& option, const std::string& taken, const std::string& other) {
    optics.warnings.push_back(option + " says " + taken + ", " + name + " of the recording " + other + ": " + option +
                              " is used");
  };
  if (options.refractive_index) {
    if (*recorded && *options.refractive_index != optics.media.water)
      contradicts("--refractive-index", number_text(*options.refractive_index), number_text(optics.media.water));
    optics.media.water = *options.refractive_index;
    index_from = "--refractive-index";
  }
  if (!options.plates.empty()) {
    if (*recorded && !same_plates(options.plates, plates_of(optics.media)))
      contradicts("--plate", plates_text(options.plates), plates_text(plates_of(optics.media)));
    set_plates(optics.media, options.plates);
    plates_from = "--plate";
  }
  optics.head.push_back("water: index " + number_text(optics.media.water) + " (from " + index_from + "); " +
                        plates_text(plates_of(optics.media)) + " (from " + plates_from + ")");
  return optics;
}

Outcome<dsp::ModeList> modes_of(const ReconstructOptions& options, const std::optional<dsp::SurfaceModel<double>>& recorded) {
  if (options.modes.empty() && !options.model && recorded) return recorded->modes;
  if (options.modes.empty()) return dsp::ModeList::standard(options.model.value_or(kDefaultParameters)).value();
  std::vector<dsp::Mode> modes;
  std::string given;
  bool known = true;
  for (const std::string& name : options.modes) {
    given += (given.empty() ? "" : ",") + name;
    const auto mode = dsp::Mode::parse(name);
    known = known && mode.has_value();
    if (mode) modes.push_back(*mode);
  }
  const auto list = dsp::ModeList::make(modes);
  if (!known || !list)
    return Problem{Exit::kUsage, "--modes", "", "1 to 24 different modes of A00, B, C and Amn with one digit each", given, ""};
  return *list;
}

// Rows and columns of points that are listed row by row; nothing for other lists.
PatternSize listed_rows(const Points& points) {
  const auto pattern = dsp::Pattern::make(points, dsp::FirstSquare::kUnknown);
  if (!pattern || pattern->rows() * pattern->columns() != pattern->size()) return {};
  for (int i = 0; i < pattern->size(); ++i)
    if (pattern->at(i / pattern->columns(), i % pattern->columns()) != i) return {};
  return {pattern->rows(), pattern->columns()};
}

Outcome<RunPlan> plan_of(const ReconstructOptions& options, const Recording& recording, const Optics& optics) {
  if (options.features)
    return Problem{Exit::kUsage, "--features is for OpenSRD settings", options.source.string(), "a settings.xml", "", ""};
  if (options.model == 2)
    return Problem{Exit::kUsage,
                   "--model level-normal is for settings of the 2017 release",
                   options.source.string(),
                   "1, 3 (plane), 5, 8 or 12",
                   "",
                   ""};
  if ((!options.lx || !options.ly) && !optics.model)
    return Problem{
        Exit::kUsage, "--lx and --ly are missing", options.source.string(), "the length scales of the surface model, mm",
        "",           "add --lx MM --ly MM"};
  RunPlan plan;
  const auto modes = modes_of(options, optics.model);
  if (!modes) return modes.error();
  const dsp::SurfaceModel<double> known = optics.model.value_or(dsp::SurfaceModel<double>{});
  plan.model = {*modes, options.lx.value_or(known.lx), options.ly.value_or(known.ly), known.x0, known.y0};
  plan.media = optics.media;
  plan.options.metric = options.metric.value_or(dsp::Metric::kReprojection);
  plan.options.loss = options.loss;
  plan.options.free_index = options.free_index;
  const std::size_t n = static_cast<std::size_t>(modes->size());
  if (options.guess.empty() || options.guess.size() > n)
    return Problem{Exit::kUsage,
                   "--guess",
                   options.source.string(),
                   "1 to " + std::to_string(n) + " numbers (mm), the depth first",
                   std::to_string(options.guess.size()) + " numbers",
                   "add --guess DEPTH"};
  plan.guess = dsp::Coefficients<double>::Zero(static_cast<Eigen::Index>(n));
  for (std::size_t j = 0; j < options.guess.size(); ++j) plan.guess[static_cast<Eigen::Index>(j)] = options.guess[j];
  if (plan.media.n_layers > 0 && modes->size() > 0 && (*modes)[0].name() == dsp::Mode{}.name() &&
      !(plan.guess[0] > plan.media.plates()))
    return Problem{Exit::kUsage,
                   "--guess lies in the floor plates",
                   options.source.string(),
                   "a depth above the pattern of more than the plates' " + number_text(plan.media.plates()) + " mm",
                   number_text(plan.guess[0]) + " mm",
                   "heights count from the pattern, not from the plates"};

  RunCamera camera;
  camera.name = "camera 1";
  const Outcome<Calibration> calibration = read_calibration(recording.folder / kCalibrationName);
  if (!calibration) return calibration.error();
  camera.calibration = *calibration;
  const Outcome<dsp::Pose<double>> pose = read_pose(recording.folder / kPoseName);
  if (!pose) return pose.error();
  camera.pose = *pose;
  const auto errors = read_pose_errors(recording.folder / kPoseName);
  if (!errors) return errors.error();
  camera.errors = known_errors(camera.calibration, *errors);
  const Outcome<Points> points = read_points(recording.folder / kPointsName);
  if (!points) return points.error();
  camera.points = merge_points(plan.points, *points);
  plan.pattern = listed_rows(*points);
  plan.points_file = (recording.folder / kPointsName).string();
  for (const RecordedFrame& frame : recording.frames) {
    camera.frames.push_back(recording.folder / frame.file);
    plan.sequences.push_back(frame.sequence);
    plan.times_ns.push_back(frame.time_ns);
  }
  plan.threads = options.threads;
  plan.sample_bits = options.sample_bits;
  plan.times_known = recording.listed || options.rate_hz;
  plan.cameras.push_back(std::move(camera));
  return plan;
}

}  // namespace

Outcome<void> reconstruct_recording(const ReconstructOptions& options) {
  opensrd::OutputPlan outputs;
  outputs.series = options.out / "surface.csv";
  outputs.summary = options.out / "summary.txt";
  if (auto free = opensrd::check_free(outputs, options.force); !free) return free.error();
  const Outcome<Recording> recording =
      read_recording(options.source, {options.rate_hz.value_or(1), options.rate_hz.has_value()});
  if (!recording) return recording.error();
  const Outcome<Optics> optics = optics_of(options, recording->folder);
  if (!optics) return optics.error();
  const Outcome<RunPlan> plan = plan_of(options, *recording, *optics);
  if (!plan) return plan.error();
  const Outcome<RunResult> result = run(*plan, terminal_progress());
  if (!result) return result.error();

  std::vector<std::string> warnings = optics->warnings;
  warnings.insert(warnings.end(), recording->notes.begin(), recording->notes.end());
  if (recording->cut) warnings.push_back("frames.csv ends in the middle of a line: that frame is left out");
  if (!plan->times_known)
    warnings.push_back("the recording has no frames.csv and no --rate is given: times count one second a frame");
  std::vector<std::string> head = {"recording: " + options.source.string()};
  head.insert(head.end(), optics->head.begin(), optics->head.end());
  if (auto ready = opensrd::prepare_outputs(outputs, options.force); !ready) return ready.error();
  if (auto written = write_series(outputs.series, outputs.summary, *plan, *result, head, warnings); !written)
    return written.error();
  return report(*plan, *result, head, warnings, options.out);
}

}  // namespace srd::host
