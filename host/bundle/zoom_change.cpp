// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/zoom_change.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "host/bundle/view_influence.hpp"

namespace srd::bundle {

namespace {

constexpr std::size_t kLeastViews = 3;  // on each side
constexpr double kFalseAlarm = 1e-3;    // of a set
constexpr double kLeastFreedom = 0.05;  // that a view keeps which all but decides the change by itself

// What the square of a normal number exceeds with this probability.
double square_limit(double probability) {
  double low = 0, high = 40;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle / M_SQRT2) > probability ? low : high) = middle;
  }
  return high * high;
}

// The square of the normal number that is as unlikely as this t of so many degrees (Wallace, Ann. Math. Statist. 30 (1959) 1124).
double as_normal_square(double t, double degrees) {
  const double shrink = (8 * degrees + 1) / (8 * degrees + 3);
  return shrink * shrink * degrees * std::log1p(t * t / degrees);
}

}  // namespace

std::optional<ZoomChange> find_zoom_change(const BoardShape& shape, const std::vector<BoardView>& views, const CameraFit& fit,
                                           std::span<const std::size_t> order) {
  if (order.size() < 2 * kLeastViews) return std::nullopt;
  std::vector<ReducedView> scaled;
  for (const std::size_t view : order) scaled.push_back(reduced_view(shape, views[view], fit, view));
  // In units that make the sum's diagonal 1: focal lengths and distortions are ten powers of ten apart.
  const Eigen::Index n = scaled[0].score.size();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
  for (const ReducedView& view : scaled) all += view.information;
  const Eigen::VectorXd unit = all.diagonal().cwiseSqrt().cwiseInverse();
  all = unit.asDiagonal() * all * unit.asDiagonal();
  for (ReducedView& view : scaled) {
    view.information = (unit.asDiagonal() * view.information * unit.asDiagonal()).eval();
    view.score = unit.cwiseProduct(view.score).eval();
  }
  const Eigen::LDLT<Eigen::MatrixXd> whole(all);
  Eigen::VectorXd zoom = Eigen::VectorXd::Zero(n), score = Eigen::VectorXd::Zero(n);
  for (const Eigen::Index i : {0, 1}) zoom[i] = fit.intrinsics[static_cast<std::size_t>(i)] / unit[i];
  for (const ReducedView& view : scaled) score += view.score;
  double contradictions = 0;
  for (const ViewFit& view : fit.views) contradictions += view.contradiction * static_cast<double>(n);
  const double degrees = static_cast<double>(order.size()) * static_cast<double>(n);

  ZoomChange most;
  most.limit = square_limit(kFalseAlarm / static_cast<double>(order.size() + 1 - 2 * kLeastViews));
  Eigen::MatrixXd behind = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd behind_score = Eigen::VectorXd::Zero(n);
  for (std::size_t from = order.size() - 1; from >= kLeastViews; --from) {
    behind += scaled[from].information;
    behind_score += scaled[from].score;
    if (order.size() - from < kLeastViews) continue;
    const Eigen::VectorXd pull = behind * zoom, taken_up = whole.solve(pull);
    const double information = zoom.dot(pull) - pull.dot(taken_up);
    if (!(information > 1e-9 * zoom.dot(pull))) continue;
    const double part = (taken_up.dot(score) - zoom.dot(behind_score)) / information;
    const double plain = part * part * information / fit.variance_factor;
    const double others = std::max(1.0, (contradictions - plain) / degrees);
    double scatter = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      Eigen::VectorXd along = -taken_up;
      if (i >= from) along += zoom;
      const double own = along.dot(scaled[i].information * along);
      const double left = along.dot(scaled[i].score) + own * part;
      scatter += left * left / std::max(1 - own / information, kLeastFreedom);
    }
    const double by_model = plain / others;
    const double by_views = as_normal_square(part * information / std::sqrt(scatter), static_cast<double>(order.size()) - 2);
    if (std::min(by_model, by_views) <= most.chi_square) continue;
    most.from = from;
    most.part = part;
    most.chi_square = std::min(by_model, by_views);
    most.deviation = std::sqrt(std::max(fit.variance_factor * others / information, scatter / (information * information)));
  }
  return most;
}

}  // namespace srd::bundle
