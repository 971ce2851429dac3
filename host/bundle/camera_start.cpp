// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/camera_start.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "host/bundle/lens.hpp"

namespace srd::bundle {

namespace {

// Wide and narrow lenses lie in between, in widths of the image.
constexpr double kShortest = 0.2, kLongest = 50, kUsual = 1.2;

double start_focal(double found, double side) {
  return std::isfinite(found) && found > kShortest * side && found < kLongest * side ? found : kUsual * side;
}

}  // namespace

Outcome<CameraStart> start_camera(const BoardShape& shape, const std::vector<BoardView>& views, int image_width,
                                  int image_height, int coefficients) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : views) {
    auto& object = objects.emplace_back();
    auto& image = images.emplace_back();
    for (const ViewCorner& corner : view.corners) {
      const Eigen::Vector3d p = shape.flat(corner.row, corner.column);
      object.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
      image.emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  CameraStart start;
  std::size_t at = 0;
  try {
    const cv::Mat guess = cv::initCameraMatrix2D(objects, images, {image_width, image_height}, 1);
    const double side = std::max(image_width, image_height);
    const double focal = start_focal(std::sqrt(guess.at<double>(0, 0) * guess.at<double>(1, 1)), side);
    const cv::Matx33d k(focal, 0, (image_width - 1) / 2.0, 0, focal, (image_height - 1) / 2.0, 0, 0, 1);
    start.intrinsics = {k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
    start.intrinsics.resize(static_cast<std::size_t>(kPinhole + coefficients), 0.0);
    for (; at < views.size(); ++at) {
      cv::Vec3d turn, translation;
      if (!cv::solvePnP(objects[at], images[at], k, cv::noArray(), turn, translation) || !(translation[2] > 0))
        throw std::runtime_error("no pose in front of the camera");
      PoseVector& pose = start.poses.emplace_back();
      pose << turn[0], turn[1], turn[2], translation[0], translation[1], translation[2];
    }
  } catch (const std::exception& exception) {
    return Problem{Exit::kInput,
                   "gives no pose of the board",
                   at < views.size() ? views[at].name : "",
                   "at least 4 corners of a board, not in one line",
                   exception.what(),
                   "leave the image out"};
  }
  return start;
}

}  // namespace srd::bundle
