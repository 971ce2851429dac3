// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/view_advice.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "host/bundle/lens.hpp"
#include "host/bundle/view_influence.hpp"

namespace srd::bundle {

namespace {

constexpr double kTilt = 35 / 57.29577951308232;

struct Attitude {
  Eigen::Vector3d axis;  // the camera's frame
  const char* words;
};

const std::array<Attitude, 5> kAttitudes{{{{0, 0, 0}, "square on to the camera"},
                                          {{1, 0, 0}, "its lower edge 35 degrees further away than its upper one"},
                                          {{-1, 0, 0}, "its upper edge 35 degrees further away than its lower one"},
                                          {{0, -1, 0}, "its right edge 35 degrees further away than its left one"},
                                          {{0, 1, 0}, "its left edge 35 degrees further away than its right one"}}};

std::string place_words(int row, int column) {
  static constexpr std::array kRows{"upper ", "", "lower "}, kColumns{"left", "", "right"};
  if (row == 1 && column == 1) return "in the middle of the image";
  if (column == 1) return row == 0 ? "at the top of the image" : "at the bottom of the image";
  return std::string("at the ") + kRows[static_cast<std::size_t>(row)] + kColumns[static_cast<std::size_t>(column)] +
         " of the image";
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The board as that pose would show it; empty when a corner is outside the image.
BoardView seen_from(const BoardShape& shape, const CameraFit& fit, const PoseVector& vector, double sigma, int width,
                    int height) {
  BoardView view;
  const dsp::Pose<double> pose = to_pose(vector);
  for (int row = 0; row < shape.rows; ++row)
    for (int column = 0; column < shape.columns; ++column) {
      const Eigen::Vector3d& point = fit.points[static_cast<std::size_t>(row * shape.columns + column)];
      Eigen::Vector2d pixel;
      if (!project(fit.intrinsics, pose.rotation * point + pose.translation, pixel) || pixel.x() < 0 || pixel.y() < 0 ||
          pixel.x() > width - 1 || pixel.y() > height - 1)
        return {};
      view.corners.push_back({row, column, pixel, sigma});
    }
  return view;
}

}  // namespace

NextView next_view(const BoardShape& shape, const std::vector<BoardView>& views, const CameraFit& fit, int image_width,
                   int image_height) {
  std::vector<double> sigmas, distances;
  for (const BoardView& view : views)
    for (const ViewCorner& corner : view.corners) sigmas.push_back(corner.sigma);
  const Eigen::Vector3d middle((shape.rows - 1) * shape.square_mm / 2, (shape.columns - 1) * shape.square_mm / 2, 0);
  for (const ViewFit& view : fit.views) {
    const dsp::Pose<double> pose = to_pose(view.pose);
    distances.push_back((pose.rotation * middle + pose.translation).z());
  }
  const double sigma = median(sigmas), usual = median(distances);
  const int shared = fit.lens_size() + (fit.surface == Surface::kBent ? kBend : 0), at = fit.board_at();
  Eigen::MatrixXd spread(shared, shared);
  const auto place = [&](int i) { return i < fit.lens_size() ? i : at + i - fit.lens_size(); };
  for (int i = 0; i < shared; ++i)
    for (int j = 0; j < shared; ++j) spread(i, j) = fit.covariance(place(i), place(j));
  const double growth = fit.variance_factor * (fit.views_contradict ? fit.view_factor : 1.0);
  Eigen::Matrix3d facing;
  facing << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  NextView best;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      for (const Attitude& attitude : kAttitudes) {
        const Eigen::Matrix3d turn =
            (attitude.axis.norm() > 0 ? Eigen::AngleAxisd(kTilt, attitude.axis).matrix() : Eigen::Matrix3d::Identity()) *
            facing;
        // As far out and as near as it fits.
        BoardView view;
        PoseVector pose;
        for (double far = usual; far < 3 * usual && view.corners.empty(); far *= 1.15)
          for (double out = 0.4; out > 0.05 && view.corners.empty(); out -= 0.05) {
            const double u = image_width * out * (column - 1), v = image_height * out * (row - 1);
            const Eigen::Vector3d centre(far * u / fit.intrinsics[0], far * v / fit.intrinsics[1], far);
            pose = to_vector({turn, centre - turn * middle});
            view = seen_from(shape, fit, pose, sigma, image_width, image_height);
            if (row == 1 && column == 1) break;
          }
        if (view.corners.empty()) continue;
        const Eigen::MatrixXd more =
            Eigen::MatrixXd::Identity(shared, shared) + spread * view_information(shape, view, fit, pose) / growth;
        const double gain = 1 - std::pow(std::max(more.determinant(), 1.0), -0.5 / shared);
        if (gain > best.gain) best = {pose, place_words(row, column), attitude.words, gain};
      }
  return best;
}

}  // namespace srd::bundle
