// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/ray_trace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

SurfaceModel<double> model_of(int parameters) { return {ModeList::standard(parameters).value(), 240, 440, 0, 0}; }

Media<double> water_over(std::vector<Layer<double>> plates) {
  Media<double> media;
  for (const Layer<double>& plate : plates) media.layers[static_cast<std::size_t>(media.n_layers++)] = plate;
  return media;
}

std::vector<Media<double>> dry_and_plated_floors() { return {water_over({}), water_over({{6, 1.52}, {10, 1.49}})}; }

Ray<double> slanted_ray() { return {{260, 90, 860}, Vec3<double>(-0.3, 0.22, -1).normalized()}; }

// The point that a ray at this angle reaches below level water, by Snell's law in every medium.
double sideways(double angle, double depth, const Media<double>& media) {
  const double invariant = media.air * std::sin(angle);
  double sum = depth * std::tan(std::asin(invariant / media.water));
  for (int i = 0; i < media.n_layers; ++i) {
    const auto& plate = media.layers[static_cast<std::size_t>(i)];
    sum += plate.thickness * std::tan(std::asin(invariant / plate.index));
  }
  return sum;
}

TEST(Trace, FollowsSnellsLawThroughALevelSurface) {
  const SurfaceModel<double> model = model_of(1);
  for (const Media<double>& media : dry_and_plated_floors())
    for (const double angle : {0.0, 0.2, 0.6, 1.2})
      for (const double azimuth : {0.0, 1.0, 4.0}) {
        const Vec3<double> direction(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                                     -std::cos(angle));
        const Ray<double> ray{{30, -20, 500}, direction};
        Trace<double> trace_out;
        ASSERT_TRUE(trace(ray, model, fakes::level(1, 96), media, 0.0, false, trace_out).ok());
        const double reach = 404 * std::tan(angle) + sideways(angle, 96 - media.plates(), media);
        EXPECT_NEAR(trace_out.bottom.x(), 30 + reach * std::cos(azimuth), 1e-10);
        EXPECT_NEAR(trace_out.bottom.y(), -20 + reach * std::sin(azimuth), 1e-10);
        EXPECT_NEAR(trace_out.distance, 404 / std::cos(angle), 1e-10);
      }
}

TEST(Trace, ObeysSnellsLawAtATiltedSurface) {
  const SurfaceModel<double> model = model_of(12);
  const Ray<double> ray = slanted_ray();
  Trace<double> at;
  ASSERT_TRUE(trace(ray, model, fakes::wavy(12), Media<double>{}, 0.0, false, at).ok());
  const auto cross_product = [](const Vec3<double>& a, const Vec3<double>& b) {
    return Vec3<double>(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x());
  };
  // n_air d x n = n_water v x n: angle and plane of refraction at once.
  EXPECT_LT((cross_product(ray.direction, at.normal) - 1.333 * cross_product(at.water_direction, at.normal)).norm(), 1e-14);
  EXPECT_NEAR(at.water_direction.norm(), 1, 1e-14);
  EXPECT_NEAR(at.surface_point.z(), model.height(fakes::wavy(12), at.surface_point.x(), at.surface_point.y()), 1e-10);
}

TEST(Trace, HeightAndSlopeDerivativesGiveEveryCoefficients) {
  const SurfaceModel<double> model = model_of(12);
  const auto a = fakes::wavy(12);
  for (const Media<double>& media : dry_and_plated_floors()) {
    Trace<double> at;
    ASSERT_TRUE(trace(slanted_ray(), model, a, media, 0.0, true, at).ok());
    Basis<double> basis;
    model.basis(at.surface_point.x(), at.surface_point.y(), basis);
    for (int j = 0; j < 12; ++j) {
      constexpr double kStep = 1e-4;  // mm
      auto up = a, down = a;
      up[j] += kStep;
      down[j] -= kStep;
      Trace<double> high, low;
      ASSERT_TRUE(trace(slanted_ray(), model, up, media, 0.0, false, high).ok());
      ASSERT_TRUE(trace(slanted_ray(), model, down, media, 0.0, false, low).ok());
      const Vec2<double> expected = (high.bottom - low.bottom) / (2 * kStep);
      const Vec2<double> found = at.d_height * basis.value[j] + at.d_slope * Vec2<double>(basis.dx[j], basis.dy[j]);
      EXPECT_LT((found - expected).norm(), 1e-8) << "mode " << j << ", " << media.n_layers << " plates";
    }
  }
}

TEST(Trace, DirectionDerivativeIsTheCentralDifference) {
  const SurfaceModel<double> model = model_of(12);
  const auto a = fakes::wavy(12);
  const Ray<double> ray = slanted_ray();
  for (const Media<double>& media : dry_and_plated_floors()) {
    Trace<double> at;
    ASSERT_TRUE(trace(ray, model, a, media, 0.0, true, at).ok());
    for (int axis = 0; axis < 3; ++axis) {
      // Turned, not lengthened.
      const Vec3<double> turn = Vec3<double>::Unit(axis) - ray.direction[axis] * ray.direction;
      constexpr double kStep = 1e-6;
      Trace<double> one, other;
      ASSERT_TRUE(trace({ray.origin, (ray.direction + kStep * turn).normalized()}, model, a, media, 0.0, false, one).ok());
      ASSERT_TRUE(trace({ray.origin, (ray.direction - kStep * turn).normalized()}, model, a, media, 0.0, false, other).ok());
      const Vec2<double> expected = (one.bottom - other.bottom) / (2 * kStep);
      EXPECT_LT((at.d_direction * turn - expected).norm(), 1e-4) << media.n_layers << " plates";  // of about 1e3 mm
    }
  }
}

TEST(Trace, SaysWhenTheRayNeverGetsThere) {
  const SurfaceModel<double> model = model_of(1);
  Trace<double> out;
  const Ray<double> up{{0, 0, 500}, Vec3<double>(0, 0.1, 1).normalized()};
  const Ray<double> down{{0, 0, 500}, Vec3<double>(0, 0.1, -1).normalized()};
  EXPECT_EQ(trace(up, model, fakes::level(1, 80), Media<double>{}, 0.0, false, out).error(), Errc::kOutOfDomain);
  EXPECT_EQ(trace(down, model, fakes::level(1, -5), Media<double>{}, 0.0, false, out).error(), Errc::kOutOfDomain);
  EXPECT_EQ(trace(down, model, fakes::level(1, 600), Media<double>{}, 0.0, false, out).error(), Errc::kOutOfDomain);
  EXPECT_EQ(trace(down, model, fakes::level(1, 5), water_over({{6, 1.5}}), 0.0, false, out).error(), Errc::kOutOfDomain);
  // Into a thinner medium at a flat angle: totally reflected.
  Media<double> thin;
  thin.water = 0.8;
  const Ray<double> flat{{0, 0, 500}, Vec3<double>(0, 3, -1).normalized()};
  EXPECT_EQ(trace(flat, model, fakes::level(1, 80), thin, 0.0, false, out).error(), Errc::kOutOfDomain);
}

TEST(Trace, FloatAgreesWithDoubleToATenthOfAMicrometrePerMetre) {
  const SurfaceModel<double> model = model_of(12);
  const auto a = fakes::wavy(12);
  Trace<double> wide;
  Trace<float> narrow;
  const Ray<double> ray = slanted_ray();
  ASSERT_TRUE(trace(ray, model, a, Media<double>{}, 0.0, false, wide).ok());
  ASSERT_TRUE(trace({ray.origin.cast<float>(), ray.direction.cast<float>()}, model.cast<float>(),
                    Coefficients<float>(a.cast<float>()), Media<float>{}, 0.0F, false, narrow)
                  .ok());
  EXPECT_LT((narrow.bottom.cast<double>() - wide.bottom).norm(), 5e-4);
}

TEST(SeeThrough, IsTheInverseOfTrace) {
  const fakes::Scene scene = fakes::flume_scene(12, 3);
  for (const Media<double>& media : dry_and_plated_floors())
    for (const View<double>& view : scene.views)
      for (const Vec3<double>& point : scene.points) {
        Trace<double> at;
        Mat2<double> b_xy;
        const auto start = view.normalised(point);
        ASSERT_TRUE(start.ok());
        const auto xy = see_through(view, scene.model, scene.truth, media, point, *start, at, b_xy);
        ASSERT_TRUE(xy.ok());
        Trace<double> again;
        ASSERT_TRUE(trace(view.ray(*xy), scene.model, scene.truth, media, 0.0, false, again).ok());
        EXPECT_LT((again.bottom - point.head<2>()).norm(), 1e-9);
      }
}

TEST(SeeThrough, JacobianIsTheCentralDifference) {
  const fakes::Scene scene = fakes::flume_scene(12, 1);
  const View<double>& view = scene.views[0];
  for (const Media<double>& media : dry_and_plated_floors()) {
    const Vec3<double> point(140, 60, 0);
    Trace<double> at;
    Mat2<double> b_xy;
    const auto xy = see_through(view, scene.model, scene.truth, media, point, *view.normalised(point), at, b_xy);
    ASSERT_TRUE(xy.ok());
    for (int axis = 0; axis < 2; ++axis) {
      constexpr double kStep = 1e-6;
      const Vec2<double> h = kStep * Vec2<double>::Unit(axis);
      Trace<double> one, other;
      ASSERT_TRUE(trace(view.ray(*xy + h), scene.model, scene.truth, media, 0.0, false, one).ok());
      ASSERT_TRUE(trace(view.ray(*xy - h), scene.model, scene.truth, media, 0.0, false, other).ok());
      EXPECT_LT(((one.bottom - other.bottom) / (2 * kStep) - b_xy.col(axis)).norm(), 1e-4);  // of about 1e3 mm
    }
  }
}

TEST(SeeThrough, RefusesWhatTheCameraCannotSee) {
  const fakes::Scene scene = fakes::flume_scene(5, 1);
  Trace<double> at;
  Mat2<double> b_xy;
  const auto dry = see_through(scene.views[0], scene.model, fakes::level(5, -10), scene.media, Vec3<double>(100, 200, 0),
                               Vec2<double>(0, 0), at, b_xy);
  ASSERT_FALSE(dry.ok());
  EXPECT_EQ(dry.error(), Errc::kOutOfDomain);
}

TEST(Cross, PartialsAreCentralDifferences) {
  const Vec3<double> d = slanted_ray().direction;
  const double zx = 0.05, zy = -0.08, height = 83, step = 1e-6;
  for (const Media<double>& media : dry_and_plated_floors()) {
    const auto offset = [&](const Vec3<double>& direction, double slope_x, double slope_y, double h) {
      Crossing<double> out;
      EXPECT_TRUE(cross(direction, slope_x, slope_y, h, media, false, out));
      return out.offset;
    };
    Crossing<double> at;
    ASSERT_TRUE(cross(d, zx, zy, height, media, true, at));
    const Vec2<double> by_height = (offset(d, zx, zy, height + step) - offset(d, zx, zy, height - step)) / (2 * step);
    EXPECT_LT((at.by_height - by_height).norm(), 1e-7);
    const Vec2<double> by_x = (offset(d, zx + step, zy, height) - offset(d, zx - step, zy, height)) / (2 * step);
    const Vec2<double> by_y = (offset(d, zx, zy + step, height) - offset(d, zx, zy - step, height)) / (2 * step);
    EXPECT_LT((at.by_slope.col(0) - by_x).norm(), 1e-6);
    EXPECT_LT((at.by_slope.col(1) - by_y).norm(), 1e-6);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3<double> h = step * Vec3<double>::Unit(axis);
      const Vec2<double> by = (offset(d + h, zx, zy, height) - offset(d - h, zx, zy, height)) / (2 * step);
      EXPECT_LT((at.by_direction.col(axis) - by).norm(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace srd::dsp
