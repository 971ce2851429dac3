// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <optional>

#include "drivers/recording/image_file.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "host/run/diagnosis.hpp"
#include "host/run/first_surface.hpp"
#include "host/run/ordered_work.hpp"
#include "host/run/placed_board.hpp"
#include "host/run/pose_estimation.hpp"
#include "host/run/run_kinds.hpp"
#include "proto/frame_from_estimate.hpp"

namespace srd::host {

namespace {

using Tracker = dsp::SurfaceTracker<double>;

using Images = Outcome<std::vector<GrayImage>>;
struct ReadFrame {
  Images images;
  double seconds = 0;
};

double seconds_since(std::chrono::steady_clock::time_point began) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

Images read_frame(const RunPlan& plan, std::size_t i) {
  std::vector<GrayImage> images;
  for (const RunCamera& camera : plan.cameras) {
    Outcome<GrayImage> image = read_gray_image(camera.frames[i], plan.sample_bits);
    if (!image) return image.error();
    if (auto right = check_size(image->view(), camera.calibration, camera.frames[i]); !right) return right.error();
    images.push_back(std::move(image).value());
  }
  return images;
}

std::vector<GrayView> views_of(const std::vector<GrayImage>& images) {
  std::vector<GrayView> views;
  for (const GrayImage& image : images) views.push_back(image.view());
  return views;
}

// What the first frame tells when every camera shows the whole pattern in it: the points follow from their order, as in
// the published method, so neither a bad guess nor an unknown colour of the first square matters.
struct Opening {
  dsp::Coefficients<double> guess;
  dsp::FirstSquare first = dsp::FirstSquare::kDark;
  double rms_px = 0;
};

std::optional<Opening> open(const RunPlan& plan, const std::vector<GrayImage>& images,
                            const std::vector<dsp::View<double>>& views, double square) {
  std::vector<std::vector<dsp::Observation<double>>> observed;
  std::size_t most = 0;
  Opening opening;
  for (std::size_t c = 0; c < plan.cameras.size(); ++c) {
    const RunCamera& camera = plan.cameras[c];
    if (plan.pattern.count() != static_cast<int>(camera.points.size())) return std::nullopt;
    const auto corners = find_board_corners(images[c].view(), plan.pattern, plan.search, camera.name);
    if (!corners) return std::nullopt;
    auto placed = placed_board(plan, camera, *corners);
    if (!placed) return std::nullopt;
    if (c == 0) {
      const auto& point = plan.points[static_cast<std::size_t>(placed->front().point)];
      const bool bright = first_square_bright(corners->front(), point, square, views[0]);
      opening.first = bright ? dsp::FirstSquare::kBright : dsp::FirstSquare::kDark;
    }
    most += placed->size();
    observed.push_back(std::move(*placed));
  }
  auto first = FirstSurface::make(plan, static_cast<int>(most));
  if (!first) return std::nullopt;
  std::vector<dsp::CameraObservations<double>> cameras;
  for (std::size_t c = 0; c < views.size(); ++c) cameras.push_back({&views[c], observed[c]});
  const auto found = first->find(cameras, plan.guess);
  if (!found) return std::nullopt;
  opening.guess = found->coefficients;
  opening.rms_px = found->reprojection_rms;
  return opening;
}

dsp::SurfaceTrackerOptions tracker_options(const RunPlan& plan, double rms_px) {
  dsp::SurfaceTrackerOptions options;
  options.detector.response.radius = plan.search.radius;
  options.detector.threshold = plan.search.threshold;
  options.detector.min_distance = static_cast<int>(plan.search.min_distance);
  options.search_radius = std::clamp(static_cast<int>(plan.match_radius_px), 1, 15);
  // A print or a calibration that leaves more than usual does so in every frame.
  options.max_rms_px = std::max(options.max_rms_px, 3 * rms_px);
  // The published metrics count every corner alike, leave none out and know no deviation.
  const bool published = plan.options.metric != dsp::Metric::kReprojection;
  options.weigh_corners = !published;
  if (published) options.outlier_factor = options.max_deviation_mm = 0;
  return options;
}

}  // namespace

Outcome<RunResult> run_images(const RunPlan& plan, const Progress& progress) {
  const std::size_t total = plan.cameras.front().frames.size();
  // Each frame is tracked from the one before, in order; reading and decoding, most of the time, goes on ahead.
  OrderedWork<ReadFrame> reading(plan.threads, total, static_cast<std::size_t>(2 * plan.threads), [&](std::size_t i, int) {
    const auto began = std::chrono::steady_clock::now();
    Images images = read_frame(plan, i);
    return ReadFrame{std::move(images), seconds_since(began)};
  });
  ReadFrame read = reading.take();
  if (!read.images) return read.images.error();
  const auto make_pattern = [&](dsp::FirstSquare first) { return dsp::Pattern::make(plan.points, first); };
  auto pattern = make_pattern(dsp::FirstSquare::kDark);
  if (!pattern || pattern->rows() < 2 || pattern->columns() < 2)
    return Problem{Exit::kInput,
                   "the feature points are not corners of a checkerboard",
                   plan.points_file,
                   "points on a square grid along X and Y, to 5 % of a square, not all in one line",
                   pattern ? "points in one line" : "other points",
                   "check the points' file"};
  std::vector<dsp::View<double>> views;
  std::vector<dsp::CameraSetup<double>> setups;
  for (std::size_t c = 0; c < plan.cameras.size(); ++c) {
    views.push_back({plan.cameras[c].calibration.camera, plan.cameras[c].pose});
    setups.push_back({views[c], (*read.images)[c].width, (*read.images)[c].height, {}});
  }
  std::vector<std::string> notes;
  const std::optional<Opening> opening = open(plan, *read.images, views, pattern->square());
  if (opening) pattern = make_pattern(opening->first);
  for (std::size_t c = 0; c < plan.cameras.size(); ++c)
    if (const std::string bits = bits_advice((*read.images)[c], "--bits"); !bits.empty())
      notes.push_back(plan.cameras[c].frames.front().string() + ": " + bits);
  const auto make_tracker = [&](const dsp::Pattern& of) {
    return Tracker::make(setups, of, plan.model, plan.media, opening ? opening->guess : plan.guess, plan.options,
                         tracker_options(plan, opening ? opening->rms_px : 0));
  };
  auto tracker = make_tracker(*pattern);
  if (!tracker) return unusable_model(tracker.error());

  RunResult result{{}, notes, {}};
  if (!opening && plan.pattern.count() > 0)
    result.warnings.push_back(plan.cameras.front().frames.front().string() +
                              ": the first frame does not show the whole pattern in every camera; the search starts "
                              "from the guess");
  for (std::size_t i = 0; i < total; ++i) {
    if (i > 0) read = reading.take();
    const auto began = std::chrono::steady_clock::now();
    FrameRecord record;
    record.name = plan.cameras.front().frames[i].filename().string();
    record.sequence = plan.sequences[i];
    record.time_ns = plan.times_ns[i];
    record.corners.resize(plan.cameras.size());
    if (!read.images) {
      // One damaged image among thousands costs its own frame only.
      const Problem& problem = read.images.error();
      result.warnings.push_back(problem.where + ": " + problem.what + "; the frame has no surface");
      record.status = proto::FrameStatus::kBadFrame;
      result.frames.push_back(std::move(record));
      if (progress) progress(i + 1, total);
      continue;
    }
    const dsp::FrameResult<double>& found = tracker->process(views_of(*read.images), plan.times_ns[i]);
    record.expected = found.expected;
    record.found = found.found;
    if (found.has_estimate() || found.status == dsp::TrackStatus::kSolverFailed) record.estimate = found.estimate;
    record.status = proto::status_of(found);
    for (std::size_t c = 0; c < plan.cameras.size(); ++c)
      record.corners[c].assign(found.observations[c].begin(), found.observations[c].end());
    record.seconds = read.seconds + seconds_since(began);
    result.frames.push_back(std::move(record));
    if (progress) progress(i + 1, total);
  }
  const bool nothing =
      std::none_of(result.frames.begin(), result.frames.end(), [](const FrameRecord& frame) { return frame.has_surface(); });
  if (nothing && !opening) {
    // Where the whole board was seen, its colours were, too.
    const std::size_t i = typical_frame(result);
    const Images images = read_frame(plan, i);
    const auto swapped = make_pattern(dsp::FirstSquare::kBright);
    auto trial = swapped ? make_tracker(*swapped) : Result<Tracker>(Errc::kInvalidArgument);
    if (images && trial && trial->process(views_of(*images), plan.times_ns[i]).has_surface())
      result.diagnosis = plan.cameras.front().frames[i].string() +
                         ": gives a surface when black and white are swapped: the first square of the points (between the "
                         "first corner and the next ones along X and Y) is bright in it. Invert the images, or list the points "
                         "from a corner whose square is dark";
  }
  return result;
}

}  // namespace srd::host
