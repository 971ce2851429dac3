// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/reconstruction.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/text_file.hpp"
#include "host/opensrd/frame_list.hpp"
#include "host/opensrd/patch_run.hpp"
#include "host/run/series.hpp"

namespace srd::host::opensrd {

namespace {

namespace fs = std::filesystem;

std::string rounded(double value, int decimals) {
  std::array<char, 64> buffer;
  const int length = std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

Outcome<Points> points_of(const fs::path& file, PatternSize size, const std::string& keys) {
  Outcome<Points> points = read_points(file);
  if (points && static_cast<int>(points->size()) != size.count())
    return Problem{Exit::kInput,
                   "has the wrong number of points",
                   file.string(),
                   std::to_string(size.count()) + ": " + std::to_string(size.rows) + " rows of " +
                       std::to_string(size.columns) + " (" + keys + ")",
                   std::to_string(points->size()),
                   "mend the file or the settings"};
  return points;
}

// A frame that some camera lacks cannot be fitted jointly: the common ones are used.
void use_common_frames(std::vector<RunCamera>& cameras, std::vector<std::string>& warnings) {
  std::size_t least = cameras.front().frames.size(), most = least;
  std::string counts;
  for (const RunCamera& camera : cameras) {
    least = std::min(least, camera.frames.size());
    most = std::max(most, camera.frames.size());
    counts += (counts.empty() ? "" : ", ") + camera.name + " " + std::to_string(camera.frames.size());
  }
  if (least == most) return;
  for (RunCamera& camera : cameras) camera.frames.resize(least);
  warnings.push_back("the cameras have different numbers of frames (" + counts + "): the first " + std::to_string(least) +
                     " of each are used, to " + cameras.front().frames.back().filename().string());
}

}  // namespace

Outcome<Preparation> prepare(const Settings& settings, const Overrides& overrides) {
  if (settings.dialect == Dialect::k2017) return prepare_patch(settings, overrides);
  Preparation made;
  RunPlan& plan = made.plan;
  plan.sample_bits = overrides.sample_bits;
  made.warnings = settings.warnings;
  plan.pattern = settings.pattern;
  plan.search = {settings.response_radius, settings.response_threshold, settings.min_distance_px};
  plan.match_radius_px = settings.match_radius_px;
  plan.from_images = settings.features_from_images && !overrides.features;
  plan.model.modes = dsp::ModeList::standard(settings.parameters).value();
  plan.model.lx = settings.lx;
  plan.model.ly = settings.ly;
  plan.media.water = overrides.refractive_index.value_or(kPublishedIndex);
  plan.guess = Eigen::Map<const Eigen::VectorXd>(settings.guess.data(), settings.parameters);
  plan.options.free_index = overrides.free_index;
  plan.options.metric = overrides.metric.value_or(settings.metric);
  plan.options.epsg = settings.epsg;
  plan.options.epsf = settings.epsf;
  plan.options.epsx = settings.epsx;
  plan.options.max_iterations = settings.max_iterations;
  plan.options.scale = settings.scale;

  made.head.push_back("settings: " + settings.file.string() + " (" + to_string(settings.dialect) + ")");
  set_plates(plan.media, overrides.plates);
  if (!overrides.plates.empty()) made.head.push_back(plates_text(overrides.plates) + ": from --plate");
  for (std::size_t i = 0; i < settings.cameras.size(); ++i) {
    const CameraSettings& given = settings.cameras[i];
    RunCamera camera;
    camera.name = "camera " + std::to_string(i + 1);
    const Outcome<Calibration> calibration = read_calibration(given.calibration);
    if (!calibration) return calibration.error();
    camera.calibration = *calibration;

    const Outcome<Points> features = points_of(given.feature_points, settings.pattern, "the feature pattern's size");
    if (!features) return features.error();
    camera.points = merge_points(plan.points, *features);
    if (i == 0) plan.points_file = given.feature_points.string();

    std::optional<PoseFit> fit;
    std::string pose_line = camera.name + ": pose from " + given.reference.string();
    if (settings.pose_from_image) {
      Points board = board_points(settings.board, settings.square_mm);
      if (settings.dialect != Dialect::kGuide) {
        const Outcome<Points> read = points_of(given.pose_points, settings.board, "the reference pattern's size");
        if (!read) return read.error();
        board = *read;
      }
      Outcome<PoseFit> fitted = pose_from_image(given.reference, *calibration, seen_order(board, given.position),
                                                settings.board, plan.search, plan.sample_bits);
      if (!fitted) return fitted.error();
      fit = *fitted;
      made.warnings.insert(made.warnings.end(), fit->warnings.begin(), fit->warnings.end());
      camera.pose = fit->pose;
      camera.errors = known_errors(*calibration, errors_of(*fit));
      pose_line += ", " + std::to_string(fit->corners) + " corners, " + rounded(fit->rms_px, 4) + " px rms per axis, worst " +
                   rounded(fit->worst_px, 3) + " px";
    } else {
      const Outcome<dsp::Pose<double>> pose = read_pose(given.reference);
      if (!pose) return pose.error();
      camera.pose = *pose;
      const auto errors = read_pose_errors(given.reference);
      if (!errors) return errors.error();
      camera.errors = known_errors(*calibration, *errors);
    }
    const dsp::Vec3<double> centre = camera.pose.centre();
    made.head.push_back(pose_line + "; centre " + rounded(centre.x(), 2) + " " + rounded(centre.y(), 2) + " " +
                        rounded(centre.z(), 2) + " mm");
    made.fits.push_back(fit);

    Outcome<std::vector<fs::path>> frames = overrides.features ? saved_features(*overrides.features, given, i, settings)
                                            : plan.from_images ? image_files(given.frames, made.warnings)
                                                               : feature_files(given.frames, made.warnings);
    if (!frames) return frames.error();
    camera.frames = std::move(frames).value();
    plan.cameras.push_back(std::move(camera));
  }
  use_common_frames(plan.cameras, made.warnings);
  const fs::path& first = plan.cameras.front().frames.front();
  if (!settings.features_from_images && !overrides.features && first.filename() == frame_file_name(0))
    made.warnings.push_back(first.parent_path().string() +
                            ": Frame_0.txt is taken as the first frame (guide 3.2: names are "
                            "chronological); files that a run on images wrote start at the last: give them with --features");
  number_frames(plan, overrides.rate_hz);
  return made;
}

Outcome<void> write_results(const OutputPlan& outputs, const Settings& settings, const Preparation& preparation,
                            const RunResult& result) {
  const RunPlan& plan = preparation.plan;
  if (auto done =
          write_text_file(outputs.coefficients, coefficients_text(settings.dialect, result.frames, plan.model.modes.size()));
      !done)
    return done.error();
  if (!outputs.errors.empty())
    if (auto done = write_text_file(outputs.errors, errors_text(settings.dialect, result.frames)); !done) return done.error();
  if (!outputs.centres.empty())
    if (auto done = write_text_file(outputs.centres, centres_text(settings.dialect, result.frames)); !done) return done.error();
  if (auto done = write_series(outputs.series, outputs.summary, plan, result, preparation.head, preparation.warnings); !done)
    return done.error();
  for (std::size_t c = 0; c < outputs.poses.size(); ++c)
    if (auto written = write_pose(outputs.poses[c], plan.cameras[c].pose, errors_of(*preparation.fits[c])); !written)
      return written.error();
  for (std::size_t c = 0; c < outputs.features.size(); ++c) {
    std::vector<int> ids(plan.points.size(), -1);
    for (std::size_t own = 0; own < plan.cameras[c].points.size(); ++own)
      ids[static_cast<std::size_t>(plan.cameras[c].points[own])] = static_cast<int>(own);
    if (auto written = write_feature_files(outputs.features[c], settings.dialect, result.frames, c,
                                           plan.cameras[c].calibration.camera, ids);
        !written)
      return written.error();
  }
  return {};
}

}  // namespace srd::host::opensrd
