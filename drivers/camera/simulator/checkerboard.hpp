// SPDX-License-Identifier: Apache-2.0
// A checkerboard seen through a Gaussian: the mean over a bivariate normal distribution of points on the
// board, exact for a locally linear map (straight edges that cross at any angle).
#pragma once

#include <array>
#include <vector>

namespace srd {

class FilteredCheckerboard {
 public:
  // Inner corners at x = 0..rows-1, y = 0..columns-1 (squares); see BoardPattern.
  FilteredCheckerboard(int rows, int columns, int border_squares, bool origin_dark, double margin);

  // Brightness, 0 dark square .. 1 bright one, of a normal distribution with mean (x, y) squares, inverse
  // standard deviations wx, wy (1/squares, >= kMinWeight) and correlation rho. |error| < 2e-5 for |rho| <=
  // 0.7.
  [[nodiscard]] float level(float x, float y, float wx, float wy, float rho) const {
    const int nx = nearest(x, first_, last_x_), ny = nearest(y, first_, last_y_);
    const float zx = (x - static_cast<float>(nx)) * wx, zy = (y - static_cast<float>(ny)) * wy;
    const bool far_x = zx >= kFarthest || zx <= -kFarthest, far_y = zy >= kFarthest || zy <= -kFarthest;
    if (far_x && far_y) {  // most pixels: one square, or none
      const int square_x = zx > 0 ? nx : nx - 1, square_y = zy > 0 ? ny : ny - 1;
      if (square_x < first_ || square_x >= last_x_ || square_y < first_ || square_y >= last_y_) return margin_;
      return ((square_x + square_y) & 1) == 0 ? 0.5F + sign_ : 0.5F - sign_;
    }
    return near_edge(nx, ny, zx, zy, rho);
  }

  // A square spans at least this many standard deviations, so that at most one edge a direction counts.
  static constexpr double kMinWeight = 8;

 private:
  static constexpr float kFarthest = 5;  // standard deviations; beyond, 6e-7 is left

  // One direction: mean of the +-1 square wave (0 off the board) and of "is on the board", and their jumps at
  // the edge.
  struct Edge {
    float wave, inside, wave_jump, inside_jump;
  };
  [[nodiscard]] static int nearest(float at, int first, int last) {
    if (at >= static_cast<float>(last)) return last;
    if (!(at > static_cast<float>(first))) return first;
    return static_cast<int>(at - static_cast<float>(first) + 0.5F) + first;
  }
  [[nodiscard]] Edge edge(int n, float z, int first, int last) const;
  [[nodiscard]] float near_edge(int nx, int ny, float zx, float zy, float rho) const;

  int last_x_, last_y_, first_;
  float margin_, sign_;
  std::vector<float> erf_;  // erf(z / sqrt 2) in steps of 1/kSteps
};

}  // namespace srd
