// SPDX-License-Identifier: Apache-2.0
// The slow and certain way to an image patch: 64 x 64 jittered rays a pixel, each traced to the hard-edged
// pattern, and the exact integral of the lens's Gaussian over the pixel's square. Shares nothing with the
// renderer but the ray trace.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "drivers/camera/simulator/scene.hpp"

namespace srd::fakes {

class BruteForcePatch {
 public:
  static constexpr int kHalf = 4;     // px: the patch is 9 x 9
  static constexpr int kMargin = 11;  // px around it that blur brings in
  static constexpr int kRays = 64;    // a pixel side
  static constexpr int kSide = 2 * kHalf + 1;
  using Patch = Eigen::Matrix<double, kSide, kSide>;  // (v, u)

  // What a pixel sees: place on the pattern, in squares.
  using Sight = std::function<dsp::Vec2<double>(double u, double v)>;

  BruteForcePatch(const Scene& scene, Sight seen, unsigned seed) : scene_(scene), seen_(std::move(seen)), random_(seed) {}

  // Grey levels round a corner of the pattern that the camera sees near pixel (u0, v0), no other corner
  // within reach.
  Patch around(int u0, int v0) {
    const int reach = static_cast<int>(std::ceil(5 * scene_.blur_px)) + 1;
    EXPECT_LE(reach, kMargin);
    const int pixels = kSide + 2 * reach, cells = pixels * kRays;
    // Signs of all rays, 0/1 dark/bright; uniform pixels by one ray.
    Eigen::MatrixXf fine(cells, cells);
    const int corner_u = u0 - kHalf - reach, corner_v = v0 - kHalf - reach;
    for (int v = 0; v < pixels; ++v)
      for (int u = 0; u < pixels; ++u) fill(corner_u + u, corner_v + v, u * kRays, v * kRays, fine);
    // Separable: the Gaussian integrated over a pixel that lies d away from the ray.
    const double sigma = scene_.blur_px;
    Eigen::MatrixXf weights(cells, kSide);
    for (int k = 0; k < kSide; ++k) {
      for (int c = 0; c < cells; ++c) {
        const double d = (c + 0.5) / kRays - 0.5 - (k + reach);
        weights(c, k) = static_cast<float>(
            sigma > 0 ? 0.5 * (std::erf((d + 0.5) / (sigma * M_SQRT2)) - std::erf((d - 0.5) / (sigma * M_SQRT2)))
                      : (std::abs(d) < 0.5 ? 1.0 : 0.0));
      }
      weights.col(k) /= weights.col(k).sum();
    }
    const Eigen::MatrixXf rows = fine * weights;  // cells x kSide
    const Eigen::MatrixXf patch = weights.transpose() * rows;
    return (scene_.light.dark + (scene_.light.bright - scene_.light.dark) * patch.cast<double>().array()).matrix();
  }

 private:
  bool bright(const dsp::Vec2<double>& at) const {
    const bool odd = (static_cast<long>(std::floor(at.x())) + static_cast<long>(std::floor(at.y()))) % 2 != 0;
    return odd == scene_.pattern.origin_dark;
  }
  void fill(int u, int v, int column, int row, Eigen::MatrixXf& fine) {
    const dsp::Vec2<double> middle = seen_(u, v);
    const dsp::Vec2<double> right = seen_(u + 1, v), below = seen_(u, v + 1);
    const double du = std::abs(right.x() - middle.x()) + std::abs(below.x() - middle.x());
    const double dv = std::abs(right.y() - middle.y()) + std::abs(below.y() - middle.y());
    const auto off = [](double x) { return std::abs(x - std::round(x)); };
    if (off(middle.x()) > 0.6 * du && off(middle.y()) > 0.6 * dv) {
      fine.block(row, column, kRays, kRays).setConstant(bright(middle) ? 1 : 0);
      return;
    }
    std::uniform_real_distribution<double> jitter(0, 1);
    for (int i = 0; i < kRays; ++i)
      for (int j = 0; j < kRays; ++j) {
        const double ray_u = u - 0.5 + (j + jitter(random_)) / kRays, ray_v = v - 0.5 + (i + jitter(random_)) / kRays;
        fine(row + i, column + j) = bright(seen_(ray_u, ray_v)) ? 1 : 0;
      }
  }

  const Scene& scene_;
  Sight seen_;
  std::mt19937 random_;
};

// Through the water, ray by ray.
inline BruteForcePatch::Sight traced_sight(const Scene& scene, const dsp::Coefficients<double>& a) {
  return [&scene, a](double u, double v) -> dsp::Vec2<double> {
    const auto xy = scene.calibration.camera.undistort({u, v});
    dsp::Trace<double> traced;
    if (!dsp::trace(scene.view().ray(*xy), scene.surface, a, scene.media, 0.0, false, traced))
      return dsp::Vec2<double>::Constant(std::numeric_limits<double>::quiet_NaN());
    return traced.bottom / scene.pattern.square_mm;
  };
}

// How far (px) the patch lies off the reference, by least squares over all pixels but the outermost, with a
// free offset.
inline Eigen::Vector2d patch_shift(const BruteForcePatch::Patch& reference, const BruteForcePatch::Patch& patch) {
  constexpr int kInner = BruteForcePatch::kSide - 2;
  Eigen::Matrix<double, kInner * kInner, 3> design;
  Eigen::Matrix<double, kInner * kInner, 1> difference;
  for (int v = 1; v <= kInner; ++v)
    for (int u = 1; u <= kInner; ++u) {
      const int k = (v - 1) * kInner + u - 1;
      // patch(x) = reference(x - shift)
      design.row(k) << -(reference(v, u + 1) - reference(v, u - 1)) / 2, -(reference(v + 1, u) - reference(v - 1, u)) / 2, 1;
      difference[k] = patch(v, u) - reference(v, u);
    }
  return design.colPivHouseholderQr().solve(difference).head<2>();
}

}  // namespace srd::fakes
