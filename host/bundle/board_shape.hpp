// SPDX-License-Identifier: Apache-2.0
// A board's own frame: Z = 0 through its rim, origin at its first corner, X along rows' numbers, Y along columns', mm.
// A bent board is a paraboloid: Z = along_rows (1 - x^2) + along_columns (1 - y^2), x and y from -1 to 1 over the
// corners, optics (30) (the form of mrcal's calobject_warp), so each number is how far the middle stands out from the ends.
#pragma once

#include <Eigen/Core>

namespace srd::bundle {

inline constexpr int kBend = 2;

struct BoardShape {
  int rows = 0, columns = 0;  // inner corners
  double square_mm = 0;

  [[nodiscard]] int count() const { return rows * columns; }
  // How Z answers to the two numbers of the bend at a corner.
  [[nodiscard]] Eigen::Vector2d bend_weights(int row, int column) const {
    const auto arch = [](int i, int n) {
      const double at = n > 1 ? 2.0 * i / (n - 1) - 1 : 0;
      return 1 - at * at;
    };
    return {arch(row, rows), arch(column, columns)};
  }
  [[nodiscard]] Eigen::Vector3d flat(int row, int column) const { return {row * square_mm, column * square_mm, 0}; }
  [[nodiscard]] Eigen::Vector3d bent(int row, int column, const Eigen::Vector2d& bend) const {
    return {row * square_mm, column * square_mm, bend.dot(bend_weights(row, column))};
  }
};

}  // namespace srd::bundle
