// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/patch_run.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/text_file.hpp"
#include "host/opensrd/frame_list.hpp"
#include "host/run/pattern_mask.hpp"

namespace srd::host::opensrd {

namespace {

using dsp::Vec2;
using dsp::Vec3;

std::string pixels_text(const Region& region) {
  return "u " + std::to_string(region.u0) + ".." + std::to_string(region.u1) + ", v " + std::to_string(region.v0) + ".." +
         std::to_string(region.v1);
}

Outcome<void> check_request(const Settings& settings, const Overrides& overrides) {
  const std::string file = settings.file.string();
  if (overrides.metric)
    return Problem{Exit::kUsage, "--metric is for corners",
                   file,         "the pattern metric, which is what settings of the 2017 release are for",
                   "",           "leave --metric out"};
  if (overrides.features)
    return Problem{Exit::kUsage, "--features is for corners", file, "images: the pattern metric uses their pixels", "", ""};
  return {};
}

// The release's list, and a list row by row for those who made theirs so: the image tells which fits.
Outcome<PoseFit> pose_of(const CameraSettings& camera, const Calibration& calibration, const Points& listed,
                         const Settings& settings, int sample_bits, dsp::CheckerPlane& plane) {
  const Outcome<GrayImage> image = read_gray_image(camera.reference, sample_bits);
  if (!image) return image.error();
  if (auto right = check_size(image->view(), calibration, camera.reference); !right) return right.error();
  const CornerSearch search{settings.response_radius, settings.response_threshold, settings.min_distance_px};
  const auto corners = find_board_corners(image->view(), settings.board, search, camera.reference.string());
  if (!corners) return corners.error();
  Points seen = rows_from_columns(listed, settings.board);
  Outcome<PoseFit> fit = fit_pose(calibration, with_points(*corners, seen), camera.reference.string());
  if (!fit) {
    const Outcome<PoseFit> by_rows = fit_pose(calibration, with_points(*corners, listed), camera.reference.string());
    if (!by_rows) return fit;
    fit = by_rows;
    seen = listed;
  }
  const double square = settings.patch.square_mm;
  const Vec3<double>& point = seen.front();
  plane.square_mm = square;
  plane.x = point.x() - square * std::round(point.x() / square);
  plane.y = point.y() - square * std::round(point.y() / square);
  plane.z = point.z();
  plane.dark = !first_square_bright(corners->front(), point, square, {calibration.camera, fit->pose});
  return fit;
}

// Neighbours in the list lie a square apart.
Outcome<void> check_spacing(const Points& listed, const Settings& settings, const std::filesystem::path& file) {
  const double spacing = (listed[1] - listed[0]).norm(), square = settings.patch.square_mm;
  if (std::abs(spacing - square) <= 0.01 * square) return {};
  return Problem{Exit::kInput,
                 "does not agree with gridSize",
                 file.string(),
                 "points " + number_text(square) + " mm apart",
                 number_text(spacing) + " mm",
                 "mend gridSize or the points"};
}

// The settings' guess in the run's form; the release's form and a plane translate into each other.
dsp::Coefficients<double> guess_of(const Settings& settings, int parameters) {
  const std::vector<double>& given = settings.guess;
  const bool from_release = settings.parameters == 2, to_release = parameters == 2;
  dsp::Coefficients<double> guess = dsp::Coefficients<double>::Zero(parameters);
  for (std::size_t j = 0; j < given.size() && j < static_cast<std::size_t>(parameters); ++j)
    guess[static_cast<Eigen::Index>(j)] = given[j];
  if (from_release == to_release) return guess;
  if (to_release) {
    guess[1] *= dsp::kNormalScale / settings.lx;
  } else if (parameters >= 3) {
    guess[1] *= settings.lx / dsp::kNormalScale;
    guess[2] = -dsp::kNormalY * settings.ly;
  } else {
    guess = guess.head(1).eval();
  }
  return guess;
}

// To what a list of points is written with.
bool same_board(const dsp::CheckerPlane& a, const dsp::CheckerPlane& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) < 1e-3; };
  return a.dark == b.dark && near(a.x, b.x) && near(a.y, b.y) && near(a.z, b.z);
}

struct RegionPlace {
  Vec3<double> ray;                   // direction through the middle of the pixels that show the pattern
  Vec3<double> middle;                // where it meets the surface of the guess
  std::vector<Vec3<double>> corners;  // and where rays through the outermost such pixels do
};

// From a camera's first image.
Outcome<RegionPlace> place_region(const RunPlan& plan, std::size_t index) {
  const PatternRun& pattern = *plan.pattern_run;
  const RunCamera& camera = plan.cameras[index];
  const std::filesystem::path& file = camera.frames.front();
  const Outcome<GrayImage> image = read_gray_image(file, plan.sample_bits);
  if (!image) return image.error();
  if (auto right = check_size(image->view(), camera.calibration, file); !right) return right.error();
  const Region& region = pattern.regions[index];
  if (region.u1 > image->width || region.v1 > image->height)
    return Problem{Exit::kUsage,        "the region reaches beyond the image",
                   file.string(),       "at most u " + std::to_string(image->width) + ", v " + std::to_string(image->height),
                   pixels_text(region), "mend max_u and max_v in the settings"};
  const auto mask = pattern_mask(image->view(), region, pattern.dark_below, pattern.bright_above);
  const int width = region.u1 - region.u0;
  Vec2<double> sum(0, 0);
  double n = 0;
  Region seen{region.u1, region.v1, region.u0, region.v0};
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const int u = region.u0 + static_cast<int>(i) % width, v = region.v0 + static_cast<int>(i) / width;
    sum += Vec2<double>(u, v);
    n += 1;
    seen = {std::min(seen.u0, u), std::min(seen.v0, v), std::max(seen.u1, u), std::max(seen.v1, v)};
  }
  if (n == 0)
    return Problem{Exit::kInput,        "shows nothing in the region",
                   file.string(),       "pixels darker than minThreshold or brighter than maxThreshold",
                   pixels_text(region), "check the region and the thresholds in the settings"};
  const dsp::View<double> view{camera.calibration.camera, camera.pose};
  const auto meet = [&](double u, double v, Vec3<double>& direction) -> Result<Vec3<double>> {
    const auto xy = view.camera.undistort({u, v});
    if (!xy) return xy.error();
    direction = view.ray(*xy).direction;
    dsp::Trace<double> way;
    const auto followed =
        pattern.surface.follow({view.pose.centre(), direction}, plan.guess, plan.media, pattern.plane.z, way, 0);
    if (!followed) return followed.error();
    return way.surface_point;
  };
  RegionPlace out;
  Vec3<double> unused;
  const auto middle = meet(sum.x() / n, sum.y() / n, out.ray);
  for (const double u : {seen.u0, seen.u1})
    for (const double v : {seen.v0, seen.v1})
      if (const auto corner = meet(u, v, unused)) out.corners.push_back(*corner);
  if (!middle || out.corners.size() < 4)
    return Problem{Exit::kInput,
                   "the region's rays do not meet the surface of the guess",
                   file.string(),
                   "a guess above the pattern and below the camera",
                   "",
                   "check InitialGuess and the region"};
  out.middle = *middle;
  return out;
}

// The origin of the model is the middle of the regions' middles; their outermost places are the plan's points.
Outcome<void> place_regions(RunPlan& plan) {
  PatternRun& pattern = *plan.pattern_run;
  plan.points.clear();
  Vec3<double> middle = Vec3<double>::Zero();
  for (std::size_t i = 0; i < plan.cameras.size(); ++i) {
    const auto place = place_region(plan, i);
    if (!place) return place.error();
    if (i == 0) pattern.centre_ray = place->ray;
    middle += place->middle / static_cast<double>(plan.cameras.size());
    plan.points.insert(plan.points.end(), place->corners.begin(), place->corners.end());
  }
  const auto tenths = [](double mm) { return std::round(10 * mm) / 10; };
  plan.model.x0 = tenths(middle.x());
  plan.model.y0 = tenths(middle.y());
  pattern.surface.model = plan.model;
  return {};
}

// Calibration, pose and frames of a camera, and how the pattern lies and is coloured as its reference shows it.
Outcome<RunCamera> patch_camera(const Settings& settings, std::size_t index, int sample_bits, dsp::CheckerPlane& plane,
                                Preparation& made) {
  const CameraSettings& given = settings.cameras[index];
  RunCamera camera;
  camera.name = "camera " + std::to_string(index + 1);
  const Outcome<Calibration> calibration = read_calibration(given.calibration);
  if (!calibration) return calibration.error();
  camera.calibration = *calibration;
  const Outcome<Points> listed = read_points(given.pose_points);
  if (!listed) return listed.error();
  if (static_cast<int>(listed->size()) != settings.board.count())
    return Problem{Exit::kInput,
                   "has the wrong number of points",
                   given.pose_points.string(),
                   std::to_string(settings.board.count()) + " (the reference pattern's size)",
                   std::to_string(listed->size()),
                   "mend the file or the settings"};
  if (auto good = check_spacing(*listed, settings, given.pose_points); !good) return good.error();
  const Outcome<PoseFit> fit = pose_of(given, *calibration, *listed, settings, sample_bits, plane);
  if (!fit) return fit.error();
  made.fits.push_back(*fit);
  made.warnings.insert(made.warnings.end(), fit->warnings.begin(), fit->warnings.end());
  camera.pose = fit->pose;
  const Vec3<double> centre = camera.pose.centre();
  const auto hundredths = [](double mm) { return number_text(std::round(100 * mm) / 100); };
  made.head.push_back(camera.name + ": pose from " + given.reference.string() + ", " + std::to_string(fit->corners) +
                      " corners, " + number_text(std::round(1e4 * fit->rms_px) / 1e4) + " px rms per axis; centre " +
                      hundredths(centre.x()) + " " + hundredths(centre.y()) + " " + hundredths(centre.z()) + " mm; region " +
                      pixels_text(given.region));
  Outcome<std::vector<std::filesystem::path>> frames = image_files(given.frames, made.warnings);
  if (!frames) return frames.error();
  camera.frames = std::move(frames).value();
  return camera;
}

}  // namespace

Points rows_from_columns(const Points& listed, PatternSize board) {
  Points seen;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      seen.push_back(listed[static_cast<std::size_t>(column * board.rows + (board.rows - 1 - row))]);
  return seen;
}

Outcome<Preparation> prepare_patch(const Settings& settings, const Overrides& overrides) {
  if (auto good = check_request(settings, overrides); !good) return good.error();
  Preparation made;
  RunPlan& plan = made.plan;
  plan.sample_bits = overrides.sample_bits;
  made.warnings = settings.warnings;
  made.head.push_back("settings: " + settings.file.string() + " (" + to_string(settings.dialect) + ")");
  if (!settings.pose_from_image)
    return Problem{Exit::kUsage,           "the pattern metric needs the reference image",
                   settings.file.string(), "TypeCameraPose 1: the image tells the colour of the squares too",
                   "TypeCameraPose 0",     ""};
  PatternRun pattern;
  pattern.dark_below = settings.patch.dark_below;
  pattern.bright_above = settings.patch.bright_above;
  for (std::size_t i = 0; i < settings.cameras.size(); ++i) {
    dsp::CheckerPlane plane;
    auto camera = patch_camera(settings, i, overrides.sample_bits, plane, made);
    if (!camera) return camera.error();
    if (i == 0) pattern.plane = plane;
    if (!same_board(plane, pattern.plane))
      return Problem{Exit::kInput,
                     "shows the pattern in another place or other colours than the first camera's reference",
                     settings.cameras[i].reference.string(),
                     "one pattern, and lists of points that begin at the same of its corners",
                     "",
                     "check InputReference and InputInitial of the cameras"};
    if (i > 0 && camera->frames.size() != plan.cameras.front().frames.size())
      return Problem{Exit::kInput,
                     "has another number of images than the first camera's folder",
                     settings.cameras[i].frames.string(),
                     std::to_string(plan.cameras.front().frames.size()),
                     std::to_string(camera->frames.size()),
                     "images of one moment, one a camera, in the order of their names"};
    pattern.regions.push_back(settings.cameras[i].region);
    plan.cameras.push_back(std::move(*camera));
  }

  const int parameters = overrides.model.value_or(settings.parameters);
  const bool release = parameters == 2;
  pattern.surface.form = release ? dsp::SurfaceForm::kLevelAndNormal : dsp::SurfaceForm::kModes;
  // In the series the release's form goes by the modes that mean the same: a level, and a slope over 100 mm along X.
  const std::array<dsp::Mode, 2> level_and_slope{dsp::Mode{}, dsp::Mode{dsp::Mode::Kind::kSlopeX, 0, 0}};
  plan.model.modes = release ? dsp::ModeList::make(level_and_slope).value() : dsp::ModeList::standard(parameters).value();
  plan.model.lx = release ? dsp::kNormalScale : settings.lx;
  plan.model.ly = release ? dsp::kNormalScale : settings.ly;
  plan.media.water = overrides.refractive_index.value_or(kPublishedIndex);
  plan.guess = guess_of(settings, parameters);
  // The settings know one dark and one bright level for the whole region.
  pattern.options.gradients = false;
  pattern.options.epsg = settings.epsg;
  pattern.options.epsf = settings.epsf;
  pattern.options.epsx = settings.epsx;
  pattern.options.max_iterations = settings.max_iterations;
  const bool scaled = std::any_of(settings.scale.begin(), settings.scale.end(), [](double x) { return x != 1; });
  if (scaled && parameters == settings.parameters) pattern.options.scale = settings.scale;
  pattern.surface.model = plan.model;
  plan.pattern_run = pattern;

  if (auto placed = place_regions(plan); !placed) return placed.error();
  made.head.push_back(
      release ? "surface form: level-normal, the 2017 release's: level A00 for the intersection, normal (-B/100, 0.07, 1); "
                "an approximation of a local plane"
              : "surface form: modes");
  made.head.push_back("model origin X " + number_text(plan.model.x0) + " Y " + number_text(plan.model.y0) + " mm");
  number_frames(plan, overrides.rate_hz);
  return made;
}

}  // namespace srd::host::opensrd
