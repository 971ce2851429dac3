// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/model_check.hpp"

#include <Eigen/Cholesky>

#include "host/bundle/chi_square.hpp"

namespace srd::bundle {

namespace {

constexpr std::size_t kMinViews = 6;
constexpr double kOnceIn1000 = 3.09, kOnceIn10000 = 3.719;

// Lens and bend, and their covariance.
struct Shared {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

Shared shared_part(const CameraFit& fit) {
  const int n = fit.lens_size(), bend = fit.surface == Surface::kBent ? kBend : 0, at = fit.board_at();
  Shared part;
  part.values.resize(n + bend);
  part.covariance.resize(n + bend, n + bend);
  const auto place = [&](int i) { return i < n ? i : at + i - n; };
  for (int i = 0; i < n + bend; ++i) {
    part.values[i] = i < n ? fit.intrinsics[static_cast<std::size_t>(i)] : fit.bend[i - n];
    for (int j = 0; j < n + bend; ++j) part.covariance(i, j) = fit.covariance(place(i), place(j));
  }
  return part;
}

double square_in(const Eigen::MatrixXd& spread, const Eigen::VectorXd& x) {
  // Scaled to ones on the diagonal first: focal lengths and distortions are ten powers of ten apart.
  const Eigen::VectorXd unit = spread.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd scaled = unit.cwiseProduct(x);
  const Eigen::MatrixXd correlation = unit.asDiagonal() * spread * unit.asDiagonal();
  return scaled.dot(correlation.ldlt().solve(scaled));
}

}  // namespace

ModelCheck check_model(const BoardShape& shape, const std::vector<BoardView>& views, int image_width, int image_height,
                       const CameraOptions& options, const CameraFit& fit) {
  ModelCheck check;
  if (options.surface == Surface::kFlat) {
    CameraOptions bent = options;
    bent.surface = Surface::kBent;
    check.bend_limit = chi_square_limit(kBend, kOnceIn10000);
    if (const auto found = solve_camera(shape, views, image_width, image_height, bent); found.ok()) {
      check.bend = found->bend;
      check.bend_significance = square_in(found->covariance.bottomRightCorner<kBend, kBend>(), found->bend);
    }
  }
  if (views.size() >= kMinViews) {
    std::vector<BoardView> even, odd;
    for (std::size_t i = 0; i < views.size(); ++i) (i % 2 == 0 ? even : odd).push_back(views[i]);
    auto first = solve_camera(shape, even, image_width, image_height, options);
    auto second = solve_camera(shape, odd, image_width, image_height, options);
    if (first.ok() && second.ok()) {
      // What the views contradict each other by is known better from all of them.
      for (CameraFit* half : {&*first, &*second})
        if (fit.views_contradict && !half->views_contradict) half->covariance *= fit.view_factor;
      const Shared a = shared_part(*first), b = shared_part(*second);
      check.halves = square_in(a.covariance + b.covariance, a.values - b.values);
      check.halves_limit = chi_square_limit(static_cast<int>(a.values.size()), kOnceIn1000);
      check.even = std::move(*first);
      check.odd = std::move(*second);
    }
  }
  check.fits = check.halves_agree() && !check.bend_missing();
  return check;
}

}  // namespace srd::bundle
