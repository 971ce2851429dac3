// SPDX-License-Identifier: Apache-2.0
// Views of a board whose camera is known: corners by projection, with normal noise.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "host/bundle/camera_solve.hpp"
#include "host/bundle/lens.hpp"

namespace srd::bundle {

struct DrawnCamera {
  std::vector<double> lens{3700, 3710, 950, 540, -0.21, 0.15, 1e-3, -5e-4, 0.3};
  int width = 1920, height = 1080;
  BoardShape board{7, 17, 9.75};
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();
};

// The board near to the middle and in all parts of the image, tilted by 15 to 45 degrees, each time about another axis.
inline std::vector<PoseVector> drawn_poses(const DrawnCamera& camera, int views, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<PoseVector> poses;
  const Eigen::Vector3d middle((camera.board.rows - 1) * camera.board.square_mm / 2,
                               (camera.board.columns - 1) * camera.board.square_mm / 2, 0);
  // The board's rows run down the image, its columns to the right.
  Eigen::Matrix3d facing;
  facing << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  for (int i = 0; i < views; ++i) {
    const double axis = 2 * 3.14159265 * i / views, tilt = (15 + 30 * (i % 3) / 2.0) / 57.29578;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)).matrix() *
                                 Eigen::AngleAxisd(0.2 * unit(random), Eigen::Vector3d::UnitZ()).matrix() * facing;
    const double far = 600 + 150 * unit(random);
    const Eigen::Vector3d at(0.12 * far * unit(random), 0.07 * far * unit(random), far);
    poses.push_back(to_vector({turn, at - turn * middle}));
  }
  return poses;
}

inline std::vector<BoardView> drawn_views(const DrawnCamera& camera, const std::vector<PoseVector>& poses, double noise_px,
                                          std::mt19937& random) {
  std::normal_distribution<double> normal(0, noise_px);
  std::vector<BoardView> views;
  for (const PoseVector& vector : poses) {
    const dsp::Pose<double> pose = to_pose(vector);
    BoardView& view = views.emplace_back();
    view.name = "view " + std::to_string(views.size());
    for (int row = 0; row < camera.board.rows; ++row)
      for (int column = 0; column < camera.board.columns; ++column) {
        Eigen::Vector2d pixel;
        if (!project(camera.lens, pose.rotation * camera.board.bent(row, column, camera.bend) + pose.translation, pixel))
          ADD_FAILURE() << "behind the camera";
        view.corners.push_back({row, column, pixel + Eigen::Vector2d(normal(random), normal(random)), noise_px});
      }
  }
  return views;
}

}  // namespace srd::bundle
