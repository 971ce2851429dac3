// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/camera_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "dsp/optics/view.hpp"
#include "tests/dsp/lenses.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

// Points over the lens's field.
std::vector<Vec2<double>> field(const Lens& lens) {
  std::vector<Vec2<double>> out;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) out.emplace_back(lens.field * i / 4.0 + 0.003, 0.6 * lens.field * j / 4.0 - 0.002);
  return out;
}

TEST(CameraModel, JacobianIsTheCentralDifference) {
  for (const Lens& lens : lenses()) {
    const auto camera = camera_of<double>(lens);
    for (const Vec2<double>& xy : field(lens)) {
      Mat2<double> distorted_xy, pixel_xy;
      (void)camera.distort(xy, &distorted_xy);
      (void)camera.pixel(xy, &pixel_xy);
      constexpr double kStep = 1e-6;
      for (int axis = 0; axis < 2; ++axis) {
        const Vec2<double> h = kStep * Vec2<double>::Unit(axis);
        const Vec2<double> distorted = (camera.distort(xy + h) - camera.distort(xy - h)) / (2 * kStep);
        const Vec2<double> pixel = (camera.pixel(xy + h) - camera.pixel(xy - h)) / (2 * kStep);
        EXPECT_LT((distorted - distorted_xy.col(axis)).norm(), 1e-7) << lens.distortion.size();
        EXPECT_LT((pixel - pixel_xy.col(axis)).norm(), 1e-7 * lens.fx) << lens.distortion.size();
      }
    }
  }
}

TEST(CameraModel, UndistortGivesBackWhatWasDistorted) {
  for (const Lens& lens : lenses()) {
    const auto camera = camera_of<double>(lens);
    for (const Vec2<double>& xy : field(lens)) {
      const auto back = camera.undistort(camera.pixel(xy));
      ASSERT_TRUE(back.ok()) << lens.distortion.size() << " entries at " << xy.transpose();
      EXPECT_LT((*back - xy).norm(), 1e-9) << lens.distortion.size() << " entries at " << xy.transpose();
    }
  }
}

TEST(CameraModel, UndistortInFloatKeepsAHundredthOfAPixel) {
  for (const Lens& lens : lenses()) {
    const auto camera = camera_of<double>(lens);
    const auto narrow = camera.cast<float>();
    // The real calibration subtracts numbers near 50 to leave 1 at the rim: float has no digits for it there.
    const double limit_px = lens.distortion.size() == 14 && lens.distortion[0] > 100 ? 0.01 : 0.002;
    for (const Vec2<double>& xy : field(lens)) {
      const auto back = narrow.undistort(camera.pixel(xy).cast<float>());
      ASSERT_TRUE(back.ok()) << lens.distortion.size() << " entries at " << xy.transpose();
      EXPECT_LT((back->cast<double>() - xy).norm() * lens.fx, limit_px) << lens.distortion.size();
    }
  }
}

TEST(CameraModel, UndistortRefusesPixelsThatNoRayReaches) {
  // x (1 - r2) turns back at r = 1/sqrt(3), where it is 0.385.
  const std::vector<double> folding{-1, 0, 0, 0};
  const auto camera = CameraModel<double>::make(1000, 1000, 0, 0, folding).value();
  EXPECT_TRUE(camera.undistort({380, 0}).ok());
  const auto beyond = camera.undistort({390, 0});
  ASSERT_FALSE(beyond.ok());
  EXPECT_EQ(beyond.error(), Errc::kNotConverged);
  const auto nan = camera.undistort({std::numeric_limits<double>::quiet_NaN(), 0});
  ASSERT_FALSE(nan.ok());
  EXPECT_EQ(nan.error(), Errc::kInvalidArgument);
}

TEST(CameraModel, UndistortNeverAnswersWrongFarOutsideTheField) {
  // Poles and folds lie out there: a refusal is right, an answer must map back to its pixel.
  for (const Lens& lens : lenses()) {
    const auto camera = camera_of<double>(lens);
    int refused = 0;
    for (int u = -20000; u <= 20000; u += 1000)
      for (int v = -20000; v <= 20000; v += 1000) {
        const Vec2<double> pixel(u + 0.5, v + 0.25);
        const auto xy = camera.undistort(pixel);
        refused += xy.ok() ? 0 : 1;
        if (xy.ok()) {
          EXPECT_LT((camera.pixel(*xy) - pixel).norm(), 1e-4) << lens.distortion.size();
        }
      }
    if (lens.distortion.empty()) {
      EXPECT_EQ(refused, 0);
    }
  }
}

TEST(CameraModel, MakeRefusesWhatIsNoCamera) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t length : {1U, 2U, 3U, 6U, 7U, 9U, 13U, 15U})
    EXPECT_FALSE(CameraModel<double>::make(1, 1, 0, 0, std::vector<double>(length)).ok()) << length;
  EXPECT_FALSE(CameraModel<double>::make(0, 1, 0, 0, {}).ok());
  EXPECT_FALSE(CameraModel<double>::make(1, -1, 0, 0, {}).ok());
  EXPECT_FALSE(CameraModel<double>::make(1, 1, nan, 0, {}).ok());
  EXPECT_FALSE(CameraModel<double>::make(1, 1, 0, 0, std::vector<double>{0, nan, 0, 0}).ok());
  EXPECT_TRUE(CameraModel<double>::make(1, 1, 0, 0, {}).ok());
}

TEST(View, RayAndProjectionAreInverse) {
  const View<double> view = fakes::look_at(fakes::flume_camera(), {300, 120, 900}, {100, 200, 0});
  const Vec2<double> xy(0.11, -0.07);
  const Ray<double> ray = view.ray(xy);
  EXPECT_NEAR(ray.direction.norm(), 1, 1e-15);
  EXPECT_LT((ray.origin - Vec3<double>(300, 120, 900)).norm(), 1e-10);
  const auto back = view.normalised(ray.origin + 700 * ray.direction);
  ASSERT_TRUE(back.ok());
  EXPECT_LT((*back - xy).norm(), 1e-14);
  EXPECT_FALSE(view.normalised(ray.origin - 700 * ray.direction).ok());
}

TEST(View, RayJacobianIsTheCentralDifference) {
  const View<double> view = fakes::look_at(fakes::flume_camera(), {300, 120, 900}, {100, 200, 0});
  const Vec2<double> xy(0.11, -0.07);
  Eigen::Matrix<double, 3, 2> jacobian;
  (void)view.ray(xy, &jacobian);
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 2; ++axis) {
    const Vec2<double> h = kStep * Vec2<double>::Unit(axis);
    const Vec3<double> difference = (view.ray(xy + h).direction - view.ray(xy - h).direction) / (2 * kStep);
    EXPECT_LT((difference - jacobian.col(axis)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace srd::dsp
