// SPDX-License-Identifier: Apache-2.0
// Against OpenCV's own projection. Where results are the same bit for bit on every architecture, one of them
// is enough.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <vector>

#include "dsp/optics/view.hpp"
#include "tests/dsp/lenses.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

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

}  // namespace
}  // namespace srd::dsp
