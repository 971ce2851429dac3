#include "dsp/optics/camera_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "dsp/optics/view.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

struct Lens {
  double fx, fy, cx, cy;
  std::vector<double> distortion;
  double field;  // largest normalised coordinate that its image holds
};

// Every length that OpenCV writes. The rational one is a real calibration whose numerator and denominator nearly cancel.
std::vector<Lens> lenses() {
  return {
      {2150, 2150, 648, 315, {}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01, 2e-3, -1e-3, 3e-3, 1e-3}, 0.32},
      {2150, 2140, 648, 315,
       {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01, 2e-3, -1e-3, 3e-3, 1e-3, 0.02, -0.03}, 0.32},
      {3677.2454479896355, 3691.2551717542042, 861.39701539762382, 579.07482041753951,
       {5.6299665198342461e+02, 3.6617556466798925e+02, -4.0019866575092622e-03, -3.3448739522447973e-03,
        -1.0574361556358065e+03, 5.6096566458243137e+02, 5.1134300014322565e+02, -1.2666510698168281e+03, 0, 0, 0, 0,
        0, 0},
       0.28},
  };
}

template <class S>
CameraModel<S> camera_of(const Lens& lens) {
  return CameraModel<S>::make(lens.fx, lens.fy, lens.cx, lens.cy, lens.distortion).value();
}

// Points over the lens's field.
std::vector<Vec2<double>> field(const Lens& lens) {
  std::vector<Vec2<double>> out;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) out.emplace_back(lens.field * i / 4.0 + 0.003, 0.6 * lens.field * j / 4.0 - 0.002);
  return out;
}

TEST(CameraModel, ProjectsAsOpenCvDoes) {
  for (const Lens& lens : lenses()) {
    const auto camera = camera_of<double>(lens);
    View<double> view{camera, {}};
    view.pose = fakes::look_at(camera, {300, 120, 900}, {100, 200, 0}).pose;
    std::vector<cv::Point3d> points;
    for (int x = 0; x <= 200; x += 40)
      for (int y = 100; y <= 300; y += 40) points.emplace_back(x, y, 3.0 * ((x + y) % 7));
    cv::Mat rotation(3, 3, CV_64F), rodrigues;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) rotation.at<double>(i, j) = view.pose.rotation(i, j);
    cv::Rodrigues(rotation, rodrigues);
    const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
    const auto& t = view.pose.translation;
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, rodrigues, cv::Vec3d(t.x(), t.y(), t.z()), k, lens.distortion, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto xy = view.normalised({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(xy.ok());
      const Vec2<double> pixel = camera.pixel(*xy);
      EXPECT_NEAR(pixel.x(), pixels[i].x, 1e-8) << lens.distortion.size() << " entries";
      EXPECT_NEAR(pixel.y(), pixels[i].y, 1e-8) << lens.distortion.size() << " entries";
    }
  }
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
