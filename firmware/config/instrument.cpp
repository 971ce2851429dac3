// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/instrument.hpp"

#include <cmath>
#include <sstream>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/camera_errors.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/support/formatted.hpp"
#include "drivers/support/mode_names.hpp"
#include "drivers/support/system_clock.hpp"
#include "drivers/support/text_file.hpp"
#include "dsp/optics/refractive_index.hpp"
#include "firmware/config/camera_factory.hpp"
#include "firmware/config/view_check.hpp"
#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {

namespace {

constexpr std::string_view kRecordingPrefix = "recording:";

std::string config_where(const NodeConfig& config) { return config.file.string(); }

// What the camera itself knows of where it is and what it looks at.
struct Rig {
  std::optional<Calibration> calibration;
  std::optional<dsp::Pose<double>> pose;
  std::optional<PoseErrors> pose_errors{};
  std::optional<Points> points;
};

Outcome<std::filesystem::path> resolve(const NodeConfig& config, const std::string& path, const char* key) {
  if (!path.starts_with(kRecordingPrefix)) return config.file.parent_path() / path;
  if (config.camera->kind != "recording")
    return Problem{Exit::kUsage,         std::string("geometry.") + key + " is relative to a recording",
                   config_where(config), "a camera of kind recording",
                   config.camera->kind,  "give a path relative to this file"};
  return std::filesystem::path(config.camera->argument) / path.substr(kRecordingPrefix.size());
}

// A file that the configuration names, else the recording's own of the usual name when it is there.
Outcome<std::optional<std::filesystem::path>> find_file(const NodeConfig& config, const std::string& path, const char* key,
                                                        const char* usual) {
  if (!path.empty()) {
    auto resolved = resolve(config, path, key);
    if (!resolved) return resolved.error();
    return std::optional(*resolved);
  }
  if (config.camera->kind == "recording") {
    std::filesystem::path own = std::filesystem::path(config.camera->argument) / usual;
    std::error_code error;
    if (std::filesystem::exists(own, error)) return std::optional(std::move(own));
  }
  return std::optional<std::filesystem::path>();
}

Problem missing(const NodeConfig& config, const char* key, const char* usual) {
  if (config.camera->live())
    return {Exit::kUsage,
            std::string("no ") + key,
            config_where(config),
            std::string("geometry.") + key + (key == std::string_view("points") ? ", or a [pattern] grid" : ""),
            "none",
            "a live camera has no folder to find it in"};
  return {Exit::kUsage,
          std::string("no ") + key,
          config_where(config),
          std::string("geometry.") + key + ", or " + usual + " in the recording's folder",
          "neither",
          ""};
}

Points grid_points(const PatternGrid& grid) {
  Points points;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      points.emplace_back(grid.x0_mm + row * grid.square_mm, grid.y0_mm + column * grid.square_mm, 0);
  return points;
}

// The row through a point of the bottom, seen without water: water moves it by a few rows of hundreds.
std::int32_t row_of(const dsp::View<double>& view, const dsp::Vec2<double>& point, int height) {
  const auto xy = view.normalised({point.x(), point.y(), 0});
  return xy ? row_fraction_of(view.camera.pixel(*xy).y(), height) : FrameTiming::kWholeHeight / 2;
}

Outcome<Rig> read_rig(const NodeConfig& config, Rig rig) {
  auto calibration = find_file(config, config.calibration, "calibration", "calibration.yml");
  if (!calibration) return calibration.error();
  if (*calibration) {
    auto read = read_calibration(**calibration);
    if (!read) return read.error();
    rig.calibration = *read;
  }
  auto pose = find_file(config, config.pose, "pose", "pose.yml");
  if (!pose) return pose.error();
  if (*pose) {
    auto read = read_pose(**pose);
    if (!read) return read.error();
    rig.pose = *read;
    auto errors = read_pose_errors(**pose);
    if (!errors) return errors.error();
    rig.pose_errors = *errors;
  }
  if (config.pattern) {
    rig.points = grid_points(*config.pattern);
  } else {
    auto points = find_file(config, config.points, "points", "points.txt");
    if (!points) return points.error();
    if (*points) {
      auto read = read_points(**points);
      if (!read) return read.error();
      rig.points = *read;
    }
  }
  if (!rig.calibration) return missing(config, "calibration", "calibration.yml");
  if (!rig.pose) return missing(config, "pose", "pose.yml");
  if (!rig.points) return missing(config, "points", "points.txt, or a [pattern] grid");
  return rig;
}

// The water and the plates that count, and where each comes from.
struct Water {
  dsp::Media<double> media;
  std::string index_from, plates_from, notes;
};

// The configuration goes before what the simulator renders and what a recording says of itself; a recording that says
// otherwise than the configuration is told.
Outcome<Water> water_of(const NodeConfig& config, const std::optional<Scene>& scene,
                        const std::optional<RecordedOptics>& recorded) {
  Water water;
  water.media.water = dsp::water_refractive_index(20, 0, 589).value();
  water.index_from = "fresh water of 20 C";
  std::string own = "the scene";
  std::optional<dsp::Media<double>> known;
  if (scene) known = scene->media;
  if (recorded) {
    known = recorded->media;
    own = "the recording's " + std::string(kOpticsName);
  }
  if (known) {
    water.media = *known;
    water.index_from = water.plates_from = own;
  }
  const auto note = [&](const std::string& taken, const std::string& other) {
    water.notes += "note      the configuration says " + taken + ", " + own + " " + other + ": the configuration is used\n";
  };
  if (config.refractive_index) {
    if (known && *config.refractive_index != known->water)
      note("index " + number_text(*config.refractive_index), number_text(known->water));
    water.media.water = *config.refractive_index;
    water.index_from = "the configuration";
  }
  if (config.plates) {
    if (known && !same_plates(*config.plates, plates_of(*known)))
      note(plates_text(*config.plates), plates_text(plates_of(*known)));
    set_plates(water.media, *config.plates);
    water.plates_from = "the configuration";
  }
  return water;
}

// The modes are the configuration's; a length or an origin that it does not give is the simulator's or the recording's.
Outcome<dsp::SurfaceModel<double>> model_of(const NodeConfig& config, const std::optional<Scene>& scene,
                                            const std::optional<RecordedOptics>& recorded) {
  dsp::SurfaceModel<double> known{{}, 0, 0, 0, 0};
  if (scene) known = scene->surface;
  if (recorded && recorded->model) known = *recorded->model;
  const dsp::SurfaceModel<double> model{config.modes, config.lx_mm.value_or(known.lx), config.ly_mm.value_or(known.ly),
                                        config.x0_mm.value_or(known.x0), config.y0_mm.value_or(known.y0)};
  for (const auto& [length, key] : {std::pair{model.lx, "lx_mm"}, std::pair{model.ly, "ly_mm"}})
    if (!(length > 0))
      return Problem{Exit::kUsage,
                     std::string("key 'surface.") + key + "' is missing",
                     config_where(config),
                     "the length scale of the modes, mm",
                     "",
                     ""};
  return model;
}

std::string water_text(const Water& water) {
  return "water     index " + number_text(std::round(water.media.water * 1e6) / 1e6) + " (" + water.index_from + "), " +
         plates_text(plates_of(water.media)) + (water.plates_from.empty() ? "" : " (" + water.plates_from + ")") + "\n" +
         water.notes;
}

// None where the files say nothing of errors.
std::unique_ptr<CameraDoubts> doubts_of(const RecordedRig& rig, const dsp::Coefficients<float>& guess,
                                        const dsp::Vec2<double>& centre) {
  const auto known = known_errors(rig.calibration, rig.pose_errors);
  if (!known) return nullptr;
  return std::make_unique<CameraDoubts>(
      CameraDoubts{dsp::SystematicWatch({{rig.calibration.camera, rig.pose}, known->errors}, rig.calibration.image_width,
                                        rig.calibration.image_height, rig.points,
                                        {*rig.optics.model, guess.cast<double>(), rig.optics.media}, centre),
                   known->pose_date, known->calibration_date});
}

std::string errors_text(const CameraDoubts* doubts) {
  if (doubts == nullptr || doubts->watch.deviation().size() == 0)
    return "errors    of the pose are not known: frames have no systematic deviation (srd pose writes them)\n";
  return formatted("errors    systematic height deviation %.4f mm at the guess, of ", doubts->watch.height_deviation()) +
         (doubts->calibration_date ? "pose and calibration" : "the pose alone: the calibration's are not known") + "\n";
}

}  // namespace

Outcome<Instrument> make_instrument(const NodeConfig& config, FrameDeadline::Clock clock) {
  if (!config.camera)
    return Problem{Exit::kUsage, "no camera", config_where(config), "camera.source, or --camera KIND:ARG", "neither", ""};
  Instrument instrument;
  Rig rig;
  auto scene = scene_of(config);
  if (!scene) return scene.error();
  instrument.scene = std::move(scene).value();
  if (instrument.scene) {
    const Scene& rendered = *instrument.scene;
    rig = {rendered.calibration, rendered.pose, {}, rendered.points()};
  }
  std::optional<RecordedOptics> recorded;
  if (config.camera->kind == "recording") {
    auto optics = read_recorded_optics(config.camera->argument);
    if (!optics) return optics.error();
    recorded = std::move(optics).value();
  }
  const auto water = water_of(config, instrument.scene, recorded);
  if (!water) return water.error();
  auto read = read_rig(config, rig);
  if (!read) return read.error();
  rig = std::move(read).value();
  const auto wanted = model_of(config, instrument.scene, recorded);
  if (!wanted) return wanted.error();
  const dsp::SurfaceModel<float> model = wanted->cast<float>();

  const auto pattern = dsp::Pattern::make(*rig.points, config.first_square);
  if (!pattern || pattern->rows() < 2 || pattern->columns() < 2)
    return Problem{Exit::kInput,
                   "the points are no checkerboard",
                   config_where(config),
                   "corners on a square grid along X and Y, to 5 % of a square, not all in one line",
                   pattern ? "points in one line" : "other points",
                   "check the file of points"};
  const dsp::Media<float> media = water->media.cast<float>();
  dsp::Coefficients<float> guess(config.modes.size());
  for (int i = 0; i < config.modes.size(); ++i) guess[i] = static_cast<float>(config.guess[static_cast<std::size_t>(i)]);
  dsp::CameraSetup<float> setup;
  setup.view = dsp::View<double>{rig.calibration->camera, *rig.pose}.cast<float>();
  setup.width = rig.calibration->image_width;
  setup.height = rig.calibration->image_height;
  setup.region = config.region;
  if (setup.width <= 0 || setup.height <= 0)
    return Problem{Exit::kInput,
                   "the calibration does not say the image's size",
                   config_where(config),
                   "image_width and image_height",
                   "none",
                   "add them to the calibration file"};
  if (setup.region.u1 > setup.width || setup.region.v1 > setup.height)
    return Problem{Exit::kUsage,
                   "key 'detector.region_px'",
                   config_where(config),
                   "a region inside the image of " + std::to_string(setup.width) + " x " + std::to_string(setup.height),
                   std::to_string(setup.region.u1) + ", " + std::to_string(setup.region.v1),
                   ""};
  auto camera =
      make_camera(config, instrument.scene,
                  {setup.width, setup.height, row_of({rig.calibration->camera, *rig.pose}, pattern->centre(), setup.height)});
  if (!camera) return camera.error();
  instrument.camera = std::move(camera).value();
  dsp::EstimatorOptions estimator = config.estimator;
  if (config.deadline_us) {
    instrument.deadline = clock ? std::make_unique<FrameDeadline>(*config.deadline_us, std::move(clock))
                                : std::make_unique<FrameDeadline>(*config.deadline_us);
    estimator.deadline = FrameDeadline::ask;
    estimator.deadline_context = instrument.deadline.get();
  }
  dsp::SurfaceTrackerOptions options = config.tracker;
  options.now_ns = [] { return clock_ns(CLOCK_MONOTONIC); };
  auto tracker = dsp::SurfaceTracker<float>::make(std::span(&setup, 1), *pattern, model, media, guess, estimator, options);
  if (!tracker)
    return Problem{Exit::kUsage,
                   "the surface cannot be fitted with these settings",
                   config_where(config),
                   "bounds and scales that fit the modes",
                   to_string(tracker.error()),
                   ""};
  instrument.tracker = std::make_unique<dsp::SurfaceTracker<float>>(std::move(tracker).value());
  instrument.rig = {*rig.calibration, *rig.pose, rig.pose_errors, *rig.points, {water->media, *wanted}};
  instrument.doubts = doubts_of(instrument.rig, guess, pattern->centre());
  instrument.width = setup.width;
  instrument.height = setup.height;

  std::ostringstream text;
  text << "node      " << config.node_id << (config.host.empty() ? ", sends nothing" : ", sends to " + config.host) << "\n"
       << "camera    " << config.camera->text() << ", " << setup.width << " x " << setup.height << "\n"
       << "pattern   " << pattern->size() << " corners, squares of " << pattern->square() << " mm\n"
       << errors_text(instrument.doubts.get()) << water_text(*water) << "surface   " << config.modes.size()
       << " modes: " << joined(config.modes, " ") << ", Lx " << wanted->lx << " mm, Ly " << wanted->ly << " mm\n"
       << check_view(config, {rig.calibration->camera, *rig.pose}, *wanted, media.cast<double>(), pattern->points(),
                     setup.width, setup.height);
  const bool live = instrument.camera->live();
  if (auto possible = check_strobe(config.strobe, live, config_where(config)); !possible) return possible.error();
  instrument.summary = text.str() + summary_of(config.strobe, live);
  return instrument;
}

}  // namespace srd::firmware
