// SPDX-License-Identifier: Apache-2.0
// Surfaces of a sequence of frames, one to many cameras jointly, frame after frame in chronological order.
// The same plan gives the same numbers on every machine and with any number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/geometry/camera_errors.hpp"
#include "drivers/geometry/points.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/estimate/pattern_metric/pattern_estimator.hpp"
#include "host/run/board_corners.hpp"
#include "host/run/frame_record.hpp"

namespace srd::host {

struct RunCamera {
  std::string name;  // "camera 1"
  Calibration calibration;
  dsp::Pose<double> pose;
  std::optional<KnownErrors> errors{};        // none: the pose's file says nothing of its errors
  std::vector<int> points;                    // own list of points -> RunPlan::points
  std::vector<std::filesystem::path> frames;  // chronological: images or feature files
};

// What the pattern metric needs instead of points and corners.
struct PatternRun {
  std::vector<Region> regions;             // of every image of a camera; one a camera
  int dark_below = 0, bright_above = 255;  // grey levels: see pattern_mask()
  dsp::PatternSurface surface;
  dsp::CheckerPlane plane;
  dsp::PatternOptions options;
  dsp::Vec3<double> centre_ray;  // of the first camera, direction through the middle of the pixels that show the pattern
};

struct RunPlan {
  std::vector<RunCamera> cameras;  // all with the same number of frames
  Points points;                   // F of all cameras, each once, mm
  std::string points_file;         // where the first camera's come from, for messages
  PatternSize pattern;             // 0 x 0: the cameras' lists are not row by row
  dsp::SurfaceModel<double> model;
  dsp::Media<double> media;
  dsp::EstimatorOptions options;
  dsp::Coefficients<double> guess;
  std::optional<PatternRun> pattern_run;  // the pattern metric, whatever options.metric says
  bool from_images = true;
  int sample_bits = 0;  // of the images' samples, as read_gray_image takes it
  CornerSearch search;
  double match_radius_px = 10;
  // Chronological, one a frame.
  std::vector<std::uint64_t> sequences;
  std::vector<std::int64_t> times_ns;
  bool times_known = false;  // false: they only count frames, a second each
  int threads = 1;           // >= 1; results do not depend on it
};

struct RunResult {
  std::vector<FrameRecord> frames;  // chronological
  std::vector<std::string> warnings;
  std::string diagnosis;  // why nothing was measured; empty where something was, and where there are no images
};

// Called after every frame from the caller's thread.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

// kInput: the first images cannot be read or have another size than the calibration, a feature file is wrong. A later
// image that cannot be used, and a frame without a surface, are records with their status, not errors.
[[nodiscard]] Outcome<RunResult> run(const RunPlan& plan, const Progress& progress);

// Sequences and times of frames that carry none: at this rate, without one they only count.
void number_frames(RunPlan& plan, std::optional<double> rate_hz);

// One camera's points appended to all, those already there shared (to 1e-6 mm): own list -> all.
[[nodiscard]] std::vector<int> merge_points(Points& all, const Points& own);

}  // namespace srd::host
