// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/pattern.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace srd::dsp {

Result<Pattern> Pattern::make(std::span<const Vec3<double>> points, FirstSquare first) {
  if (points.size() < 2) return Errc::kInvalidArgument;
  Pattern p;
  p.first_ = first;
  p.points_.assign(points.begin(), points.end());
  double nearest2 = std::numeric_limits<double>::max();
  Vec2<double> least = points[0].head<2>(), most = least;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) return Errc::kInvalidArgument;
    least = least.cwiseMin(points[i].head<2>());
    most = most.cwiseMax(points[i].head<2>());
    for (std::size_t j = i + 1; j < points.size(); ++j)
      nearest2 = std::min(nearest2, (points[i] - points[j]).head<2>().squaredNorm());
  }
  p.square_ = std::sqrt(nearest2);
  if (!(p.square_ > 0)) return Errc::kInvalidArgument;
  p.centre_ = (least + most) / 2;
  const Vec2<double> cells = (most - least) / p.square_;
  if (cells.maxCoeff() > 1000) return Errc::kInvalidArgument;
  p.rows_ = static_cast<int>(std::lround(cells.x())) + 1;
  p.columns_ = static_cast<int>(std::lround(cells.y())) + 1;
  p.grid_.assign(static_cast<std::size_t>(p.rows_) * static_cast<std::size_t>(p.columns_), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2<double> at = (points[i].head<2>() - least) / p.square_;
    const Vec2<double> whole(std::round(at.x()), std::round(at.y()));
    if ((at - whole).cwiseAbs().maxCoeff() > 0.05) return Errc::kInvalidArgument;
    const int row = static_cast<int>(whole.x()), column = static_cast<int>(whole.y());
    int& cell = p.grid_[static_cast<std::size_t>(row * p.columns_ + column)];
    if (cell >= 0) return Errc::kInvalidArgument;
    cell = static_cast<int>(i);
    p.cell_.emplace_back(row, column);
    const auto from_origin = [&](double x) { return static_cast<std::int64_t>(std::floor(x / p.square_ + 0.5)); };
    p.odd_.push_back(((from_origin(points[i].x()) + from_origin(points[i].y())) & 1) != 0);
  }
  return p;
}

int Pattern::at(int row, int column) const {
  if (row < 0 || column < 0 || row >= rows_ || column >= columns_) return -1;
  return grid_[static_cast<std::size_t>(row * columns_ + column)];
}

}  // namespace srd::dsp
