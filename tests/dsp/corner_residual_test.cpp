// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "dsp/estimate/residual/metric.hpp"
#include "dsp/estimate/residual/ray_residual.hpp"
#include "dsp/estimate/residual/reprojection_residual.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

// One corner of the flume, its measured pixel some px beside the true one so that no residual vanishes.
struct Fixture {
  fakes::Scene scene = fakes::flume_scene(12, 1);
  Media<double> media;
  Optics<double> optics;
  Vec3<double> point{140, 60, 0};

  explicit Fixture(std::vector<Layer<double>> plates = {}) {
    for (const auto& plate : plates) media.layers[static_cast<std::size_t>(media.n_layers++)] = plate;
    scene.media = media;
    optics = Optics<double>::make(scene.model, media);
    optics.last_step = 1e-9;  // differences below show the residual's own smoothness, not the stop's
  }

  [[nodiscard]] PreparedCorner<double> corner(const Vec2<double>& beside_px) const {
    const View<double>& view = scene.views[0];
    Observation<double> seen;
    seen.pixel = view.camera.pixel(scene.seen(0, point)) + beside_px;
    seen.normalised = view.camera.undistort(seen.pixel).value();
    PreparedCorner<double> out;
    EXPECT_TRUE(prepare(seen, point, WideView(view), out));
    EXPECT_TRUE(prepare_ray(seen, WideView(view), true, out));
    out.view = &view;
    start_at_level(80.0, true, out);
    return out;
  }

  CornerResidual<double> residual(Metric metric, const Coefficients<double>& a, PreparedCorner<double> at,
                                  Basis<double>* basis = nullptr, Mat2<double>* pixel_e = nullptr) const {
    CornerResidual<double> out;
    EXPECT_TRUE(metric == Metric::kReprojection ? reprojection_residual(optics, a, at, basis, out)
                                                : ray_residual(metric, optics, a, at, basis, out, pixel_e));
    return out;
  }
};

const std::vector<std::vector<Layer<double>>> kFloors{{}, {{6, 1.52}, {10, 1.49}}};

TEST(CornerResidual, VanishesAtTheTruth) {
  for (const auto& floor : kFloors) {
    const Fixture f(floor);
    for (const Metric metric : kMetrics)
      EXPECT_LT(f.residual(metric, f.scene.truth, f.corner({0, 0})).e.norm(), 1e-9) << static_cast<int>(metric);
  }
}

TEST(CornerResidual, DerivativesAreCentralDifferences) {
  for (const auto& floor : kFloors) {
    const Fixture f(floor);
    const auto corner = f.corner({3, -2});
    for (const Metric metric : kMetrics) {
      Basis<double> basis;
      const auto at = f.residual(metric, f.scene.truth, corner, &basis);
      EXPECT_GT(at.e.norm(), 1e-4);
      for (int j = 0; j < 12; ++j) {
        constexpr double kStep = 1e-4;  // mm
        auto up = f.scene.truth, down = f.scene.truth;
        up[j] += kStep;
        down[j] -= kStep;
        const Vec2<double> expected = (f.residual(metric, up, corner).e - f.residual(metric, down, corner).e) / (2 * kStep);
        const Vec2<double> found = at.by_height * basis.value[j] + at.by_slope * Vec2<double>(basis.dx[j], basis.dy[j]);
        EXPECT_LT((found - expected).norm(), 1e-7 * (1 + expected.norm()))
            << "metric " << static_cast<int>(metric) << ", mode " << j << ", " << floor.size() << " plates";
      }
    }
  }
}

TEST(CornerResidual, PixelDerivativesOfRayMetricsAreCentralDifferences) {
  for (const auto& floor : kFloors) {
    const Fixture f(floor);
    for (const Metric metric : {Metric::kDisparity, Metric::kCollinearity}) {
      Basis<double> basis;
      Mat2<double> e_pixel;
      (void)f.residual(metric, f.scene.truth, f.corner({3, -2}), &basis, &e_pixel);
      for (int axis = 0; axis < 2; ++axis) {
        constexpr double kStep = 1e-3;  // px
        const Vec2<double> h = kStep * Vec2<double>::Unit(axis), at(3, -2);
        const Vec2<double> expected =
            (f.residual(metric, f.scene.truth, f.corner(at + h)).e - f.residual(metric, f.scene.truth, f.corner(at - h)).e) /
            (2 * kStep);
        EXPECT_LT((e_pixel.col(axis) - expected).norm(), 1e-6 * expected.norm()) << static_cast<int>(metric);
      }
    }
  }
}

TEST(CornerResidual, ReprojectionIsThePixelAtWhichThePointIsSeen) {
  for (const auto& floor : kFloors) {
    const Fixture f(floor);
    const auto corner = f.corner({3, -2});
    const auto other = fakes::wavy(12, 84);
    Trace<double> trace;
    Mat2<double> b_xy;
    const View<double>& view = f.scene.views[0];
    const auto xy = see_through(view, f.scene.model, other, f.media, f.point, *view.normalised(f.point), trace, b_xy);
    ASSERT_TRUE(xy.ok());
    const Vec2<double> expected = view.camera.pixel(*xy) - corner.pixel;
    EXPECT_LT((f.residual(Metric::kReprojection, other, corner).e - expected).norm(), 1e-8);
  }
}

TEST(CornerResidual, ReprojectionDerivativeIsTheInverseMapOfTheBottomsDerivative) {
  // de/da = -B^-1 db/da with B = db/dq of (11), by refraction.hpp's own numbers.
  const Fixture f(kFloors[1]);
  const auto corner = f.corner({3, -2});
  Basis<double> basis;
  const auto at = f.residual(Metric::kReprojection, f.scene.truth, corner, &basis);
  const View<double>& view = f.scene.views[0];
  Trace<double> trace;
  Mat2<double> b_xy, pixel_xy, xy_b;
  const auto xy = see_through(view, f.scene.model, f.scene.truth, f.media, f.point, *view.normalised(f.point), trace, b_xy);
  ASSERT_TRUE(xy.ok());
  (void)view.camera.pixel(*xy, &pixel_xy);
  ASSERT_TRUE(invert(b_xy, xy_b));
  EXPECT_LT((at.by_height + pixel_xy * xy_b * trace.d_height).norm(), 1e-8 * at.by_height.norm());
  EXPECT_LT((at.by_slope + pixel_xy * xy_b * trace.d_slope).norm(), 1e-8 * at.by_slope.norm());
}

TEST(CornerResidual, DisparityIsTheBottomPointsDistance) {
  for (const auto& floor : kFloors) {
    const Fixture f(floor);
    const auto corner = f.corner({3, -2});
    Trace<double> out;
    ASSERT_TRUE(trace(f.scene.views[0].ray(corner.normalised), f.scene.model, f.scene.truth, f.media, 0.0, false, out).ok());
    const Vec2<double> expected = out.bottom - f.point.head<2>();
    EXPECT_LT((f.residual(Metric::kDisparity, f.scene.truth, corner).e - expected).norm(), 1e-9);
  }
}

TEST(CornerResidual, CollinearityIsTheAngleBetweenTheNormals) {
  // Level water and no plates: the normal that would bend the ray to F follows from Snell's law in vectors.
  const Fixture f;
  const auto corner = f.corner({3, -2});
  const auto level = fakes::level(12, 80);
  const double t = (80 - f.scene.views[0].pose.centre().z()) / corner.direction.z();
  const Vec3<double> p = f.scene.views[0].pose.centre() + t * corner.direction;
  const Vec3<double> w = (f.point - p).normalized();
  const Vec3<double> needed = (corner.direction - 1.333 * w).normalized();
  const Vec2<double> e = f.residual(Metric::kCollinearity, level, corner).e;
  EXPECT_NEAR(e.norm(), (needed - Vec3<double>::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(e.norm(), std::acos(needed.z()), 1e-3 * e.norm());
}

TEST(CornerResidual, RefusesSurfacesThatTheRayCannotPass) {
  const Fixture f({{6, 1.52}});
  for (const Metric metric : kMetrics)
    for (const double level : {-20.0, 3.0, 1200.0}) {  // under the floor, inside the plate, over the camera
      auto corner = f.corner({0, 0});
      CornerResidual<double> out;
      const Coefficients<double> a = fakes::level(12, level);
      Basis<double>* const no_basis = nullptr;
      const bool exists = metric == Metric::kReprojection ? reprojection_residual(f.optics, a, corner, no_basis, out)
                                                          : ray_residual(metric, f.optics, a, corner, no_basis, out);
      EXPECT_FALSE(exists) << static_cast<int>(metric) << " at " << level;
    }
}

TEST(PreparedCorner, RefusesRaysThatDoNotLookDown) {
  const Fixture f;
  const View<double>& view = f.scene.views[0];
  Observation<double> seen;
  seen.normalised = {0, 0};
  PreparedCorner<double> out;
  EXPECT_TRUE(prepare(seen, f.point, WideView(view), out));
  EXPECT_TRUE(prepare_ray(seen, WideView(view), false, out));
  // In front of the camera and over the horizon.
  const Vec3<double> axis = view.pose.rotation.row(2).transpose();
  const Vec3<double> upward = view.pose.rotation * Vec3<double>(axis.x(), axis.y(), 0.01);
  ASSERT_GT(upward.z(), 0);
  seen.normalised = upward.head<2>() / upward.z();
  EXPECT_FALSE(prepare_ray(seen, WideView(view), false, out));
  const Vec3<double> behind = view.pose.centre() + 100 * (view.pose.centre() - Vec3<double>(100, 200, 0)).normalized();
  seen.normalised = {0, 0};
  EXPECT_FALSE(prepare(seen, behind, WideView(view), out));
}

}  // namespace
}  // namespace srd::dsp
