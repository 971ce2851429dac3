// SPDX-License-Identifier: Apache-2.0
// What a wrong pose does to a surface: the same change in every frame, a systematic error. Optics (29). Pure; nothing on
// the heap.
#pragma once

#include <array>
#include <span>

#include "dsp/estimate/residual/observation.hpp"
#include "dsp/estimate/solver/information.hpp"
#include "dsp/pose/seen_point.hpp"

namespace srd::dsp {

// A camera's pose with its covariance.
struct UnsurePose {
  View<double> view;
  PoseMatrix covariance = PoseMatrix::Zero();
};

// A corner in a fit: which camera, which point, how much it counts.
struct CountedCorner {
  int camera = 0;
  int point = 0;
  double sigma = 1;  // px, > 0
};

struct SystematicSurface {
  InformationMatrix<double> covariance;  // of the coefficients, mm^2
  Coefficients<double> deviation;        // of each, mm
  double height_deviation = 0;           // of the height, rms over the points, mm; as (17a)
};

// corners: of one fit of this surface by (11) from these cameras. kSingular: they do not determine the surface;
// kOutOfDomain: a corner that cannot be seen. kInvalidArgument: no camera, or more than kMaxUnsureCameras.
inline constexpr int kMaxUnsureCameras = 4;
[[nodiscard]] Result<SystematicSurface> surface_of_poses(std::span<const UnsurePose> cameras,
                                                         std::span<const Vec3<double>> points, const WaterAbove& water,
                                                         std::span<const CountedCorner> corners);

}  // namespace srd::dsp
