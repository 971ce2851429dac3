// SPDX-License-Identifier: Apache-2.0
// The systematic deviation of surfaces that come frame after frame. It follows the mean level and changes slowly, so each
// frame adds a few corners of one frame's fit, and the deviation is renewed when that fit has been gone through: bounded work
// a frame, and the same numbers whenever the same frames come. Optics (29), (29a). Pure; nothing on the heap after
// construction.
#pragma once

#include <span>
#include <vector>

#include "dsp/pose/height_of_pose.hpp"

namespace srd::dsp {

class SystematicWatch {
 public:
  static constexpr int kCornersAFrame = 4;

  // first: the surface that the first deviations are of, with all points that the image of width x height px shows. centre:
  // where a height's deviation is stated.
  SystematicWatch(const UnsurePose& camera, int width, int height, std::span<const Vec3<double>> points,
                  const WaterAbove& first, const Vec2<double>& centre);

  // A frame's surface, one number a mode of first's model, and the corners that it was fitted to.
  void follow(const Coefficients<float>& surface, std::span<const Observation<float>> corners);

  // Of each coefficient, mm; empty: no surface so far was determined by its corners.
  [[nodiscard]] const Coefficients<double>& deviation() const { return deviation_; }
  // Of the height at the centre, mm.
  [[nodiscard]] double height_deviation() const { return height_deviation_; }

 private:
  void finish();

  UnsurePose camera_;
  std::vector<Vec3<double>> points_;
  WaterAbove water_;  // of the fit that is being gone through
  Vec2<double> centre_;
  SystematicSums sums_;
  std::vector<CountedCorner> corners_;  // capacity: one a point
  std::size_t next_ = 0;
  Coefficients<double> deviation_;
  double height_deviation_ = 0;
};

}  // namespace srd::dsp
