#include "drivers/recording/recording.hpp"
#include "drivers/support/text_file.hpp"
#include "host/reconstruct/options.hpp"
#include "host/reconstruct/report.hpp"
#include "host/reconstruct/series.hpp"
#include "host/table/model_sidecar.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;

constexpr double kFreshWaterIndex = 1.333;  // optics (21): 20 C, 589 nm
constexpr int kDefaultParameters = 5;

Outcome<dsp::ModeList> modes_of(const ReconstructOptions& options) {
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

Outcome<RunPlan> plan_of(const ReconstructOptions& options, const Recording& recording) {
  if (options.features)
    return Problem{Exit::kUsage, "--features is for OpenSRD settings", options.source.string(), "a settings.xml", "", ""};
  if (!options.lx || !options.ly)
    return Problem{Exit::kUsage, "--lx and --ly are missing", options.source.string(),
                   "the length scales of the surface model, mm", "", "add --lx MM --ly MM"};
  RunPlan plan;
  const auto modes = modes_of(options);
  if (!modes) return modes.error();
  plan.model = {*modes, *options.lx, *options.ly, 0, 0};
  plan.media.water = options.refractive_index.value_or(kFreshWaterIndex);
  plan.options.metric = options.metric.value_or(dsp::Metric::kReprojection);
  const std::size_t n = static_cast<std::size_t>(modes->size());
  if (options.guess.empty() || options.guess.size() > n)
    return Problem{Exit::kUsage, "--guess", options.source.string(),
                   "1 to " + std::to_string(n) + " numbers (mm), the depth first",
                   std::to_string(options.guess.size()) + " numbers", "add --guess DEPTH"};
  plan.guess = dsp::Coefficients<double>::Zero(static_cast<Eigen::Index>(n));
  for (std::size_t j = 0; j < options.guess.size(); ++j) plan.guess[static_cast<Eigen::Index>(j)] = options.guess[j];

  RunCamera camera;
  camera.name = "camera 1";
  const Outcome<Calibration> calibration = read_calibration(recording.folder / kCalibrationName);
  if (!calibration) return calibration.error();
  camera.calibration = *calibration;
  const Outcome<dsp::Pose<double>> pose = read_pose(recording.folder / kPoseName);
  if (!pose) return pose.error();
  camera.pose = *pose;
  const Outcome<Points> points = read_points(recording.folder / kPointsName);
  if (!points) return points.error();
  camera.points = merge_points(plan.points, *points);
  plan.points_file = (recording.folder / kPointsName).string();
  for (const RecordedFrame& frame : recording.frames) {
    camera.frames.push_back(recording.folder / frame.file);
    plan.sequences.push_back(frame.sequence);
    plan.times_ns.push_back(frame.time_ns);
  }
  plan.times_known = recording.listed || options.rate_hz;
  plan.cameras.push_back(std::move(camera));
  return plan;
}

}  // namespace

Outcome<void> reconstruct_recording(const ReconstructOptions& options) {
  const fs::path series = options.out / "surface.csv", summary = options.out / "summary.txt";
  std::error_code error;
  for (const fs::path& file : {series, model_sidecar_path(series), summary})
    if (!options.force && fs::exists(file, error))
      return Problem{Exit::kUsage, "is there already", file.string(), "an --out folder without results", "",
                     "give another --out, or --force to replace the results"};
  const Outcome<Recording> recording = read_recording(options.source, options.rate_hz.value_or(1));
  if (!recording) return recording.error();
  const Outcome<RunPlan> plan = plan_of(options, *recording);
  if (!plan) return plan.error();
  const Outcome<RunResult> result = run(*plan, terminal_progress());
  if (!result) return result.error();

  std::vector<std::string> warnings;
  if (recording->cut) warnings.push_back("frames.csv ends in the middle of a line: that frame is left out");
  if (!recording->listed && !options.rate_hz)
    warnings.push_back("the recording has no frames.csv and no --rate is given: times count one second a frame");
  const std::vector<std::string> head = {"recording: " + options.source.string()};
  fs::create_directories(options.out, error);
  if (error)
    return Problem{Exit::kUsage, "cannot be made", options.out.string(), "a folder that can be written",
                   error.message(), "give another --out"};
  const std::vector<std::pair<fs::path, std::string>> files = {
      {series, series_csv(*plan, *result)},
      {model_sidecar_path(series), series_model(*plan)},
      {summary, summary_text(*plan, *result, head, warnings)}};
  for (const auto& [file, text] : files)
    if (auto written = write_text_file(file, text); !written) return written.error();
  return report(*plan, *result, head, warnings, options.out);
}

}  // namespace srd::host
