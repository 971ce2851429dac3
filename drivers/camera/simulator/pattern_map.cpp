// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/pattern_map.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace srd {

namespace {

// libm's last bits differ between machines; what is kept of a node is far above them and far below what an
// image shows.
double rounded(double x, double unit) { return std::nearbyint(x / unit) * unit; }
constexpr double kPlaceUnit = 0x1p-22;   // squares
constexpr double kWeightUnit = 0x1p-10;  // 1/squares
constexpr double kRhoUnit = 0x1p-16;
constexpr double kMinWeight = 0x1p-10;

}  // namespace

PatternMap::PatternMap(const dsp::View<double>& view, int width, int height, double square_mm, double blur_px, int step)
    : view_(view),
      centre_(view.pose.centre()),
      width_(width),
      height_(height),
      step_(step),
      columns_((width + step - 1) / step + 3),
      rows_((height + step - 1) / step + 3),
      square_mm_(square_mm),
      blur_px_(blur_px) {
  sights_.reserve(static_cast<std::size_t>(columns_ * rows_));
  for (int j = 0; j < rows_; ++j)
    for (int i = 0; i < columns_; ++i) sights_.push_back(sight((i - 1) * step, (j - 1) * step));
  nodes_.resize(sights_.size());
  whole_.resize(sights_.size());
  for (int phase = 0; phase < step; ++phase) {  // Lagrange's cubic through nodes -1, 0, 1, 2
    const double t = static_cast<double>(phase) / step;
    cubic_.push_back({static_cast<float>(-t * (t - 1) * (t - 2) / 6), static_cast<float>((t + 1) * (t - 1) * (t - 2) / 2),
                      static_cast<float>(-(t + 1) * t * (t - 2) / 2), static_cast<float>((t + 1) * t * (t - 1) / 6)});
  }
  for (auto* line : {&line_.x, &line_.y, &line_.wx, &line_.wy, &line_.rho}) line->resize(static_cast<std::size_t>(columns_));
}

PatternMap::Sight PatternMap::sight(double u, double v) const {
  Sight out;
  const auto xy = view_.camera.undistort({u, v});
  if (!xy) return out;
  dsp::Mat2<double> by_xy;
  (void)view_.camera.pixel(*xy, &by_xy);
  const double det = by_xy.determinant();
  if (!(std::abs(det) > 0)) return out;
  dsp::Mat2<double> by_pixel;
  by_pixel << by_xy(1, 1), -by_xy(0, 1), -by_xy(1, 0), by_xy(0, 0);
  Eigen::Matrix<double, 3, 2> jacobian;
  out.direction = view_.ray(*xy, &jacobian).direction;
  out.d_direction = jacobian * (by_pixel / det);
  out.valid = true;
  return out;
}

PatternMap::Seen PatternMap::seen(const Sight& sight, double& distance) const {
  Seen out{0, 0, 0, 0, 0, false};
  if (!sight.valid) return out;
  dsp::Trace<double> traced;
  if (!dsp::trace({centre_, sight.direction}, model_, coefficients_, media_, 0.0, true, traced, distance)) {
    distance = 0;
    return out;
  }
  distance = traced.distance;
  const dsp::Mat2<double> jacobian = traced.d_direction * sight.d_direction / square_mm_;  // squares / px
  const double gx = std::sqrt(jacobian.row(0).squaredNorm()), gy = std::sqrt(jacobian.row(1).squaredNorm());
  out.x = traced.bottom.x() / square_mm_;
  out.y = traced.bottom.y() / square_mm_;
  out.wx = 1 / (blur_px_ * gx);
  out.wy = 1 / (blur_px_ * gy);
  out.rho = jacobian.row(0).dot(jacobian.row(1)) / (gx * gy);
  out.valid = std::isfinite(out.x + out.y + out.wx + out.wy + out.rho) && out.wx > kMinWeight && out.wy > kMinWeight;
  return out;
}

bool PatternMap::whole(int column, int row) const { return whole_[static_cast<std::size_t>(row * columns_ + column)] != 0; }

void PatternMap::trace(const dsp::SurfaceModel<double>& model, const dsp::Coefficients<double>& a,
                       const dsp::Media<double>& media) {
  model_ = model;
  coefficients_ = a;
  media_ = media;
  for (int j = 0; j < rows_; ++j) {
    double distance = 0;
    for (int i = 0; i < columns_; ++i) {
      const auto k = static_cast<std::size_t>(j * columns_ + i);
      Seen& node = nodes_[k] = seen(sights_[k], distance);
      if (!node.valid) continue;
      node.x = rounded(node.x, kPlaceUnit);
      node.y = rounded(node.y, kPlaceUnit);
      node.wx = rounded(node.wx, kWeightUnit);
      node.wy = rounded(node.wy, kWeightUnit);
      node.rho = rounded(node.rho, kRhoUnit);
    }
  }
  for (int j = 1; j + 2 < rows_; ++j)
    for (int i = 1; i + 2 < columns_; ++i) {
      bool all = true;
      for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) all = all && nodes_[static_cast<std::size_t>((j + y) * columns_ + i + x)].valid;
      whole_[static_cast<std::size_t>(j * columns_ + i)] = all ? 1 : 0;
    }
}

void PatternMap::row(int v, PatternRow& out) {
  const int j = v / step_ + 1;
  const std::array<float, 4>& w = cubic_[static_cast<std::size_t>(v % step_)];
  const float t = static_cast<float>(v % step_) / static_cast<float>(step_);
  for (int i = 0; i < columns_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Seen* node = &nodes_[static_cast<std::size_t>((j - 1) * columns_ + i)];
    const Seen &n0 = node[0], &n1 = node[columns_], &n2 = node[2 * columns_], &n3 = node[3 * columns_];
    const auto f = [](double x) { return static_cast<float>(x); };
    line_.x[at] = w[0] * f(n0.x) + w[1] * f(n1.x) + w[2] * f(n2.x) + w[3] * f(n3.x);
    line_.y[at] = w[0] * f(n0.y) + w[1] * f(n1.y) + w[2] * f(n2.y) + w[3] * f(n3.y);
    line_.wx[at] = f(n1.wx) + t * f(n2.wx - n1.wx);
    line_.wy[at] = f(n1.wy) + t * f(n2.wy - n1.wy);
    line_.rho[at] = f(n1.rho) + t * f(n2.rho - n1.rho);
  }
  for (int u0 = 0, i = 1; u0 < width_; u0 += step_, ++i) {
    const int n = std::min(step_, width_ - u0);
    if (!whole(i, j)) {
      double distance = 0;
      for (int k = 0; k < n; ++k) {
        const auto u = static_cast<std::size_t>(u0 + k);
        const Seen one = seen(sight(u0 + k, v), distance);
        out.x[u] = static_cast<float>(rounded(one.x, kPlaceUnit));
        out.y[u] = static_cast<float>(rounded(one.y, kPlaceUnit));
        out.wx[u] = one.valid ? static_cast<float>(rounded(one.wx, kWeightUnit)) : 0.0F;
        out.wy[u] = static_cast<float>(rounded(one.wy, kWeightUnit));
        out.rho[u] = static_cast<float>(rounded(one.rho, kRhoUnit));
      }
      continue;
    }
    const auto c = static_cast<std::size_t>(i);
    const float *x = &line_.x[c - 1], *y = &line_.y[c - 1];
    const float share = 1.0F / static_cast<float>(step_);
    const float dwx = (line_.wx[c + 1] - line_.wx[c]) * share, dwy = (line_.wy[c + 1] - line_.wy[c]) * share,
                drho = (line_.rho[c + 1] - line_.rho[c]) * share;
    for (int k = 0; k < n; ++k) {
      const auto u = static_cast<std::size_t>(u0 + k);
      const std::array<float, 4>& p = cubic_[static_cast<std::size_t>(k)];
      const auto fk = static_cast<float>(k);
      out.x[u] = p[0] * x[0] + p[1] * x[1] + p[2] * x[2] + p[3] * x[3];
      out.y[u] = p[0] * y[0] + p[1] * y[1] + p[2] * y[2] + p[3] * y[3];
      out.wx[u] = line_.wx[c] + fk * dwx;
      out.wy[u] = line_.wy[c] + fk * dwy;
      out.rho[u] = line_.rho[c] + fk * drho;
    }
  }
}

double PatternMap::interpolation_error() {
  PatternRow line;
  for (auto* values : {&line.x, &line.y, &line.wx, &line.wy, &line.rho}) values->resize(static_cast<std::size_t>(width_));
  double worst = 0;
  for (int v = step_ / 2; v < height_; v += step_) {
    row(v, line);
    double distance = 0;
    for (int u = step_ / 2; u < width_; u += step_) {
      const Seen exact = seen(sight(u, v), distance);
      const auto at = static_cast<std::size_t>(u);
      if (!exact.valid || line.wx[at] == 0) continue;
      // wx blur_px is px a square.
      const double dx = (static_cast<double>(line.x[at]) - exact.x) * exact.wx * blur_px_;
      const double dy = (static_cast<double>(line.y[at]) - exact.y) * exact.wy * blur_px_;
      worst = std::max({worst, std::abs(dx), std::abs(dy)});
    }
  }
  return worst;
}

}  // namespace srd
