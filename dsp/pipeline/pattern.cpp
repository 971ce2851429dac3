// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/pattern.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace srd::dsp {

namespace {

// Mean distance of neighbours, which the errors of single points hardly move, as the least one is by the worst of them.
double mean_spacing(std::span<const Vec3<double>> points, double least) {
  constexpr double kNeighbour = 1.2;  // of the least distance; the next are across a square, 1.41
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const double distance = (points[i] - points[j]).head<2>().norm();
      if (distance > kNeighbour * least) continue;
      sum += distance;
      ++n;
    }
  return sum / n;
}

// Where the grid's first corner lies, from all points: the one of least X and Y has errors of its own.
Vec2<double> mean_start(std::span<const Vec3<double>> points, const Vec2<double>& least, double square) {
  Vec2<double> sum = Vec2<double>::Zero();
  for (const Vec3<double>& point : points) {
    const Vec2<double> at = (point.head<2>() - least) / square;
    sum += at - Vec2<double>(std::round(at.x()), std::round(at.y()));
  }
  return least + square / static_cast<double>(points.size()) * sum;
}

struct Layout {
  int rows = 0, columns = 0;
  std::vector<int> grid;
  std::vector<std::pair<int, int>> cells;
  std::vector<bool> odd;
};

// Cells of the points on a grid of this square from start. False: they are not on it.
bool lay_out(std::span<const Vec3<double>> points, const Vec2<double>& start, const Vec2<double>& most, double square,
             Layout& out) {
  const Vec2<double> cells = (most - start) / square;
  if (cells.maxCoeff() > 1000) return false;
  out = {};
  out.rows = static_cast<int>(std::lround(cells.x())) + 1;
  out.columns = static_cast<int>(std::lround(cells.y())) + 1;
  out.grid.assign(static_cast<std::size_t>(out.rows) * static_cast<std::size_t>(out.columns), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2<double> at = (points[i].head<2>() - start) / square;
    const Vec2<double> whole(std::round(at.x()), std::round(at.y()));
    if ((at - whole).cwiseAbs().maxCoeff() > 0.05) return false;
    const int row = static_cast<int>(whole.x()), column = static_cast<int>(whole.y());
    if (row < 0 || column < 0 || row >= out.rows || column >= out.columns) return false;
    int& cell = out.grid[static_cast<std::size_t>(row * out.columns + column)];
    if (cell >= 0) return false;
    cell = static_cast<int>(i);
    out.cells.emplace_back(row, column);
    const auto from_origin = [&](double x) { return static_cast<std::int64_t>(std::floor(x / square + 0.5)); };
    out.odd.push_back(((from_origin(points[i].x()) + from_origin(points[i].y())) & 1) != 0);
  }
  return true;
}

}  // namespace

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
  Layout layout;
  if (!lay_out(points, least, most, p.square_, layout)) {
    // A list that was measured: each point is off a little.
    p.square_ = mean_spacing(points, p.square_);
    if (!lay_out(points, mean_start(points, least, p.square_), most, p.square_, layout)) return Errc::kInvalidArgument;
  }
  p.rows_ = layout.rows;
  p.columns_ = layout.columns;
  p.grid_ = std::move(layout.grid);
  p.cell_ = std::move(layout.cells);
  p.odd_ = std::move(layout.odd);
  return p;
}

int Pattern::at(int row, int column) const {
  if (row < 0 || column < 0 || row >= rows_ || column >= columns_) return -1;
  return grid_[static_cast<std::size_t>(row * columns_ + column)];
}

}  // namespace srd::dsp
