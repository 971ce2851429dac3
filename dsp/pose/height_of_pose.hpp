// SPDX-License-Identifier: Apache-2.0
// What a wrong pose and a wrong calibration do to a surface: the same change in every frame, a systematic error.
// Optics (29), (29a). Pure; nothing on the heap.
#pragma once

#include <array>
#include <span>

#include "dsp/estimate/residual/observation.hpp"
#include "dsp/estimate/solver/information.hpp"
#include "dsp/pose/pose_fit.hpp"

namespace srd::dsp {

// What is not sure of a camera. The pose was found with the calibration, so that an error of that is in it, too.
struct CameraErrors {
  PoseMatrix pose = PoseMatrix::Zero();                             // covariance, if the calibration is right
  IntrinsicsMatrix calibration = IntrinsicsMatrix::Zero();          // covariance
  PoseByIntrinsics pose_by_calibration = PoseByIntrinsics::Zero();  // d pose / d intrinsics
};

struct UnsurePose {
  View<double> view;
  CameraErrors errors{};
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

  // Of the height at a place, mm.
  [[nodiscard]] double deviation_at(const SurfaceModel<double>& model, const Vec2<double>& place) const;
};

inline constexpr int kMaxUnsureCameras = 4;

// The sums over the corners of one fit of a surface by (11), corner after corner.
class SystematicSums {
 public:
  // Empty, for so many coefficients and cameras; cameras: at most kMaxUnsureCameras.
  void start(int coefficients, int cameras);
  // False, and nothing added: a corner that cannot be seen.
  [[nodiscard]] bool add(std::span<const UnsurePose> cameras, const CountedCorner& corner, const Vec3<double>& point,
                         const WaterAbove& water);
  // kSingular: the corners do not determine the surface. points: where heights count.
  [[nodiscard]] Result<SystematicSurface> surface(std::span<const UnsurePose> cameras, std::span<const Vec3<double>> points,
                                                  const SurfaceModel<double>& model) const;

 private:
  struct OfCamera {
    Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxParameters, 6> by_pose;
    Eigen::Matrix<double, Eigen::Dynamic, kMaxIntrinsics, 0, kMaxParameters, kMaxIntrinsics> by_intrinsics;
  };
  InformationMatrix<double> information_;
  std::array<OfCamera, kMaxUnsureCameras> cameras_;
  int n_cameras_ = 0;
};

// corners: of one fit of this surface by (11) from these cameras. kSingular: they do not determine the surface;
// kOutOfDomain: a corner that cannot be seen. kInvalidArgument: no camera, or more than kMaxUnsureCameras.
[[nodiscard]] Result<SystematicSurface> surface_of_poses(std::span<const UnsurePose> cameras,
                                                         std::span<const Vec3<double>> points, const WaterAbove& water,
                                                         std::span<const CountedCorner> corners);

}  // namespace srd::dsp
