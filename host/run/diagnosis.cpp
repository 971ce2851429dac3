// SPDX-License-Identifier: Apache-2.0
#include "host/run/diagnosis.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "drivers/camera/image_sketch.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/formatted.hpp"
#include "host/run/first_surface.hpp"
#include "host/run/placed_board.hpp"

namespace srd::host {

namespace {

constexpr double kFits = 3;       // px, of a board seen through a surface that is not the model's by more than waves are
constexpr double kFarBetter = 4;  // times

using Corners = std::vector<BoardCorner>;

// The corners of the image turned as given, again from its top left.
Corners turned(const Corners& corners, PatternSize board, int width, int height, bool across, bool down) {
  Corners all;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const int from_row = down ? board.rows - 1 - row : row, from_column = across ? board.columns - 1 - column : column;
      BoardCorner corner = corners[static_cast<std::size_t>(from_row * board.columns + from_column)];
      if (across) corner.pixel.x() = width - 1 - corner.pixel.x();
      if (down) corner.pixel.y() = height - 1 - corner.pixel.y();
      if (across != down) corner.bright_below_right = !corner.bright_below_right;
      all.push_back(corner);
    }
  return all;
}

// px rms of the best surface from the guess through these corners alone; nothing: there is none.
std::optional<double> best_rms(const RunPlan& plan, const RunCamera& camera, const Corners& corners) {
  const auto observed = placed_board(plan, camera, corners);
  if (!observed) return std::nullopt;
  auto first = FirstSurface::make(plan, static_cast<int>(observed->size()));
  if (!first) return std::nullopt;
  const dsp::View<double> view{camera.calibration.camera, camera.pose};
  const dsp::CameraObservations<double> seen{&view, *observed};
  const auto found = first->find(std::span(&seen, 1), plan.guess);
  return found ? std::optional(found->reprojection_rms) : std::nullopt;
}

std::string board_diagnosis(const RunPlan& plan, const RunCamera& camera, const GrayView& image) {
  if (plan.pattern.count() != static_cast<int>(camera.points.size())) return {};
  const auto corners = find_board_corners(image, plan.pattern, plan.search, camera.name);
  if (!corners) {
    const Problem& problem = corners.error();
    return problem.what + ": expected " + problem.expected + ", found " + problem.found +
           ". Is the whole pattern in view, in focus and with nothing before it; are the points of the file its own?";
  }
  struct Turn {
    const char* words;
    bool across, down;
  };
  constexpr std::array<Turn, 3> kTurns{{{"turned by half a turn", true, true},
                                        {"upside down (its rows from the last to the first)", false, true},
                                        {"mirrored (its columns from the last to the first)", true, false}}};
  const auto upright = best_rms(plan, camera, *corners);
  const std::string as_it_is =
      upright ? formatted("the best surface leaves %.2f px rms", *upright) : std::string("no surface explains it");
  std::optional<double> best;
  const char* words = nullptr;
  for (const Turn& turn : kTurns) {
    const auto rms = best_rms(plan, camera, turned(*corners, plan.pattern, image.width, image.height, turn.across, turn.down));
    if (!rms || (best && *best <= *rms)) continue;
    best = rms;
    words = turn.words;
  }
  const std::string whole = "shows the whole board; ";
  if (best && *best < kFits && (!upright || kFarBetter * *best < *upright))
    return whole + "as it is, " + as_it_is + "; " + words + formatted(" it is %.2f px. ", *best) +
           "The image is not as the camera of the pose gives it: turn the images, or estimate the pose from images that are "
           "turned the same way";
  if (upright && *upright < kFits)
    return whole + as_it_is + ", so pose and points fit: is the guess the water's level, with the pattern at 0?";
  return whole + as_it_is +
         ": are pose, calibration, points (size of the squares), index and floor plates those of these images?";
}

}  // namespace

std::size_t typical_frame(const RunResult& result) {
  std::map<proto::FrameStatus, int> counts;
  for (const FrameRecord& frame : result.frames) ++counts[frame.status];
  const auto commonest =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto at = std::find_if(result.frames.begin(), result.frames.end(),
                               [&](const FrameRecord& frame) { return frame.status == commonest->first; });
  return static_cast<std::size_t>(at - result.frames.begin());
}

std::string diagnosis(const RunPlan& plan, std::size_t frame) {
  std::string sound;
  for (const RunCamera& camera : plan.cameras) {
    const std::filesystem::path& file = camera.frames[frame];
    const Outcome<GrayImage> image = read_gray_image(file, plan.sample_bits);
    if (!image) return file.string() + " " + image.error().what + ": " + image.error().found;
    if (const std::string bits = bits_advice(*image, "--bits"); !bits.empty()) return file.string() + ": " + bits;
    const ImageSketch sketch(image->view());
    const bool good = sketch.fault() == ImageFault::kNone;
    const std::string board = good && !plan.pattern_run ? board_diagnosis(plan, camera, image->view()) : std::string();
    std::string text = file.string() + (board.empty() ? ": " + sketch.diagnosis() : " " + board);
    if (!good) return text;
    if (sound.empty()) sound = std::move(text);
  }
  return sound;
}

}  // namespace srd::host
