// SPDX-License-Identifier: Apache-2.0
// The checkerboard on the bottom: its corners, which are neighbours, and which squares are dark.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dsp/core/linear_algebra.hpp"
#include "dsp/core/result.hpp"

namespace srd::dsp {

// What is known of the square whose corners are (0,0) and (1,1) squares in W.
enum class FirstSquare : std::uint8_t { kDark, kBright, kUnknown };

// Corners on a square grid along X and Y, any subset of it, in any order.
class Pattern {
 public:
  // points: mm, W, at least two. kInvalidArgument when they do not lie on a square grid to 5 % of a square.
  [[nodiscard]] static Result<Pattern> make(std::span<const Vec3<double>> points, FirstSquare first);

  [[nodiscard]] int size() const { return static_cast<int>(points_.size()); }
  [[nodiscard]] std::span<const Vec3<double>> points() const { return points_; }
  [[nodiscard]] double square() const { return square_; }  // mm
  [[nodiscard]] FirstSquare first_square() const { return first_; }
  // Grid coordinates of a point, squares along X and Y, counted from the corner of least X and least Y.
  [[nodiscard]] int row(int point) const { return cell_[static_cast<std::size_t>(point)].first; }
  [[nodiscard]] int column(int point) const { return cell_[static_cast<std::size_t>(point)].second; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }
  // The point at grid coordinates, -1 where there is none.
  [[nodiscard]] int at(int row, int column) const;
  // Corners of even parity have the same polarity as the one at W's origin.
  [[nodiscard]] bool odd(int point) const { return odd_[static_cast<std::size_t>(point)]; }
  // X and Y of the middle of the points, mm.
  [[nodiscard]] Vec2<double> centre() const { return centre_; }

 private:
  std::vector<Vec3<double>> points_;
  std::vector<std::pair<int, int>> cell_;
  std::vector<bool> odd_;
  std::vector<int> grid_;
  int rows_ = 0, columns_ = 0;
  double square_ = 0;
  FirstSquare first_ = FirstSquare::kDark;
  Vec2<double> centre_ = Vec2<double>::Zero();
};

}  // namespace srd::dsp
