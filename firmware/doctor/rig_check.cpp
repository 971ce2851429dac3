// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/rig_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "drivers/support/formatted.hpp"
#include "dsp/frontend/board_finder.hpp"
#include "dsp/pose/pose_check.hpp"

namespace srd::firmware {

namespace {

constexpr int kMaxBoardCorners = 4096;
constexpr double kFractions = 4096;
// As srd rig-check: an unmoved rig is told as moved once in a million, and moves below the detector's own errors are none.
constexpr double kFalseAlarm = 1e-6, kLeastMovePx = 0.02;
constexpr double kLeastSigmaPx = 0.005;
// Water that moves leaves the corners far more apart than their deviations and still water with a good print do.
constexpr double kRestlessPx = 0.3;
constexpr const char* kMovedAdvice =
    "a new reference image and srd pose: with the old pose every height is off; then find what gave way (clamps, the tripod, "
    "the "
    "pattern on the floor)";

// Where the stated pose sees each point; nothing for those that it does not see.
std::vector<std::optional<dsp::Vec2<double>>> expected_pixels(const Instrument& instrument, const dsp::WaterAbove* water) {
  const dsp::View<double> view{instrument.rig.calibration.camera, instrument.rig.pose};
  std::vector<std::optional<dsp::Vec2<double>>> pixels;
  for (const dsp::Vec3<double>& point : instrument.tracker->pattern().points()) {
    const auto seen = dsp::see_point(view, point, water);
    pixels.push_back(seen ? std::optional(seen->pixel) : std::nullopt);
  }
  return pixels;
}

struct Placed {
  std::vector<dsp::PoseCorner> corners;
  double off_px = HUGE_VAL;  // from where they are expected, mean
};

// The grid's cells on the pattern's, turned and mirrored in one of eight ways; the whole pattern must be there.
Placed placed(const dsp::CornerGrid& grid, std::span<const dsp::CornerFit> fits, const dsp::Pattern& pattern, int way,
              const std::vector<std::optional<dsp::Vec2<double>>>& expected) {
  Placed out;
  double sum = 0;
  const bool swapped = (way & 4) != 0;
  if ((swapped ? grid.columns : grid.rows) != pattern.rows() || (swapped ? grid.rows : grid.columns) != pattern.columns())
    return out;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const int cell = grid.at(row, column);
      if (cell < 0) continue;
      int r = swapped ? column : row, c = swapped ? row : column;
      if ((way & 1) != 0) r = pattern.rows() - 1 - r;
      if ((way & 2) != 0) c = pattern.columns() - 1 - c;
      const int point = pattern.at(r, c);
      if (point < 0 || !expected[static_cast<std::size_t>(point)]) continue;
      const dsp::Corner& corner = fits[static_cast<std::size_t>(cell)].corner;
      const dsp::Vec2<double> pixel(corner.u.to<double>(), corner.v.to<double>());
      const double sigma = std::max(corner.sigma_q12 / kFractions, kLeastSigmaPx);
      out.corners.push_back({pattern.points()[static_cast<std::size_t>(point)], pixel, sigma});
      sum += (pixel - *expected[static_cast<std::size_t>(point)]).norm();
    }
  if (!out.corners.empty()) out.off_px = sum / static_cast<double>(out.corners.size());
  return out;
}

std::string figures_of(const dsp::PoseCheck& check) {
  constexpr double kDegrees = 180 / M_PI;
  const dsp::Vec3<double> turn = check.change.head<3>(), shift = check.change.tail<3>();
  const auto along = [](const dsp::Vec3<double>& x, const dsp::Mat3<double>& covariance) {
    const double size = x.norm();
    return size > 0 ? std::sqrt(x.dot(covariance * x)) / size : std::sqrt(covariance.trace() / 3);
  };
  std::string text = formatted("turn %.4f +- %.4f degrees, shift %.3f +- %.3f mm, corners by up to %.3f px; ",
                               turn.norm() * kDegrees, along(turn, check.covariance.topLeftCorner<3, 3>()) * kDegrees,
                               shift.norm(), along(shift, check.covariance.bottomRightCorner<3, 3>()), check.largest_move_px);
  text += formatted("by chance %.2g; ", check.by_chance);
  return text + (check.wet ? formatted("through still water of %.2f +- %.2f mm", check.level_mm, check.level_deviation_mm)
                           : std::string("seen dry"));
}

}  // namespace

bool RigCheck::moved(const dsp::PoseCheck& check) {
  return check.by_chance < kFalseAlarm && check.largest_move_px >= kLeastMovePx;
}

std::optional<dsp::PoseCheck> RigCheck::check(const GrayView& image) {
  const dsp::Pattern& pattern = instrument_.tracker->pattern();
  dsp::BoardFinder finder(image.width, image.height, kMaxBoardCorners);
  const auto grid = finder.find(image, config_.tracker.detector, {pattern.rows(), pattern.columns()});
  if (!grid) return std::nullopt;
  const double guess = config_.guess.empty() ? 0 : config_.guess[0];
  const dsp::Media<double>& media = instrument_.rig.optics.media;
  dsp::WaterAbove water{{dsp::ModeList::standard(1).value(), 1, 1, 0, 0}, dsp::Coefficients<double>(1), media};
  water.surface[0] = std::max(guess, media.plates() + 1);
  Placed best;
  const dsp::WaterAbove* const media_above[] = {nullptr, &water};
  for (const dsp::WaterAbove* above : media_above) {
    const auto expected = expected_pixels(instrument_, above);
    for (int way = 0; way < 8; ++way)
      if (Placed candidate = placed(*grid, finder.corners(), pattern, way, expected); candidate.off_px < best.off_px)
        best = std::move(candidate);
  }
  if (best.corners.size() < 8) {
    refusal_ = formatted("a grid of %d x %d corners is found, the pattern has %d x %d", grid->rows, grid->columns,
                         pattern.rows(), pattern.columns());
    return std::nullopt;
  }
  dsp::PoseCheckRequest request;
  request.camera = instrument_.rig.calibration.camera;
  request.stated = instrument_.rig.pose;
  if (instrument_.rig.pose_errors) request.stated_covariance = instrument_.rig.pose_errors->covariance;
  request.media = media;
  request.highest_mm = 2 * guess + 100;
  const auto found = dsp::check_pose(request, best.corners);
  if (!found) {
    refusal_ = std::string("no pose agrees with its corners: ") + to_string(found.error());
    return std::nullopt;
  }
  double weights = 0;
  for (const dsp::PoseCorner& corner : best.corners) weights += 1 / (corner.sigma * corner.sigma);
  if (const double rms_px = std::sqrt(found->found.cost / (2 * weights)); rms_px > kRestlessPx) {
    refusal_ = formatted("%.2f px rms are left of its corners", rms_px);
    return std::nullopt;
  }
  return *found;
}

void RigCheck::look(const GrayView& image, std::int64_t time_ns) {
  if (!first_ns_) {
    first_ns_ = time_ns;
    first_ = check(image);
  } else if (undecided() && time_ns - *first_ns_ >= kApartNs) {
    second_ = check(image);
    // What was still then and is not now is not still.
    if (!second_) first_.reset();
  }
}

void RigCheck::tell(Diagnosis& diagnosis) const {
  const std::string still_advice =
      "this check with still water, or none, and the whole pattern in the image; where it is still: geometry.calibration, "
      "geometry.points and the index of water";
  if (!first_) {
    if (!refusal_.empty()) diagnosis.warn("rig", "not compared with the pose: " + refusal_, still_advice);
    return;
  }
  if (!moved(*first_)) {
    diagnosis.ok("rig", "as the pose says: " + figures_of(*first_));
    return;
  }
  if (!second_) {
    diagnosis.warn("rig",
                   "not compared with the pose: it differs in the one frame that came in time, as it would through waves",
                   still_advice);
    return;
  }
  if (dsp::by_chance_between(*first_, *second_) < kFalseAlarm) {
    diagnosis.warn("rig", "not compared with the pose: the water moves", still_advice);
    return;
  }
  diagnosis.warn("rig",
                 "camera or pattern has moved since the pose was found: " + figures_of(*first_) +
                     (instrument_.rig.pose_errors ? "" : "; the pose's own errors are not known and count as none"),
                 kMovedAdvice);
}

}  // namespace srd::firmware
