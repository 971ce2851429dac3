// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/camera_solve.hpp"

#include <algorithm>
#include <cmath>

#include "host/bundle/camera_problem.hpp"
#include "host/bundle/camera_start.hpp"
#include "host/bundle/lens.hpp"
#include "host/bundle/view_influence.hpp"

namespace srd::bundle {

namespace {

using Residuals = std::vector<std::vector<Eigen::Vector2d>>;

constexpr int kMaxRounds = 12;
constexpr double kMaxAddedPx = 100;

template <class Visit>
void each_corner(const std::vector<BoardView>& views, Visit visit) {
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t c = 0; c < views[v].corners.size(); ++c) visit(v, c, views[v].corners[c]);
}

// Robust deviation of the residuals in units of their stated ones: the median length of two normal numbers is 1.1774.
double robust_ratio(const std::vector<BoardView>& views, const Residuals& residuals, double added_px) {
  std::vector<double> lengths;
  each_corner(views, [&](std::size_t v, std::size_t c, const ViewCorner& corner) {
    lengths.push_back(residuals[v][c].norm() / std::hypot(corner.sigma, added_px));
  });
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle / 1.1774;
}

class Solver {
 public:
  Solver(const BoardShape& shape, const std::vector<BoardView>& views, const CameraOptions& options, CameraStart start)
      : shape_(shape), views_(views), options_(options) {
    state_.intrinsics = std::move(start.intrinsics);
    state_.poses = std::move(start.poses);
    for (const BoardView& view : views) weighting_.used.emplace_back(view.corners.size(), char{1});
  }

  Outcome<CameraFit> run() {
    CameraOptions first = options_;
    if (first.surface == Surface::kFree) first.surface = Surface::kBent;
    now_ = first;
    if (auto done = settle(); !done) return done.error();
    if (options_.surface == Surface::kFree) {
      now_ = options_;
      for (int row = 0; row < shape_.rows; ++row)
        for (int column = 0; column < shape_.columns; ++column) state_.points.push_back(shape_.bent(row, column, state_.bend));
      if (auto done = settle(); !done) return done.error();
    }
    return result();
  }

 private:
  // Least squares, corners that contradict it left out, and the deviations made as large as the residuals: until
  // nothing changes.
  Outcome<void> settle() {
    if (auto done = minimise_now(); !done) return done;
    if (options_.reject > 0 && worst_ratio() > options_.reject * robust_ratio(views_, residuals_, weighting_.added_px)) {
      // Far corners have pulled the plain solution: a loss that hardly minds them comes first.
      weighting_.robust = 2.5 * robust_ratio(views_, residuals_, weighting_.added_px);
      if (auto done = minimise_now(); !done) return done;
      weighting_.robust = 0;
      (void)reject();
      if (auto done = minimise_now(); !done) return done;
    }
    for (int round = 0; round < kMaxRounds; ++round) {
      const double before = weighting_.added_px;
      weigh();
      const bool other_corners = options_.reject > 0 && reject();
      const bool other_weights = std::abs(weighting_.added_px - before) > 1e-3 * (before + 1e-4);
      if (!other_corners && !other_weights) break;
      if (auto done = minimise_now(); !done) return done;
    }
    return {};
  }

  Outcome<void> minimise_now() {
    const auto problem = make_problem(shape_, views_, now_, weighting_, state_);
    const Result<int> iterations = minimise(*problem, state_);
    if (!iterations)
      return Problem{Exit::kInput,
                     "gives no calibration",
                     "",
                     "views that agree on one camera",
                     "the adjustment does not come to rest",
                     "fewer coefficients (4 or 5), or views with the board tilted by 20 to 45 degrees"};
    iterations_ += *iterations;
    residuals_ = residuals_of(shape_, views_, state_);
    return {};
  }

  [[nodiscard]] double worst_ratio() const {
    double worst = 0;
    each_corner(views_, [&](std::size_t v, std::size_t c, const ViewCorner& corner) {
      worst = std::max(worst, residuals_[v][c].norm() / std::hypot(corner.sigma, weighting_.added_px));
    });
    return worst;
  }

  // true: other corners than before are left out.
  bool reject() {
    const double most = options_.reject * robust_ratio(views_, residuals_, weighting_.added_px);
    bool changed = false;
    each_corner(views_, [&](std::size_t v, std::size_t c, const ViewCorner& corner) {
      const char used = residuals_[v][c].norm() <= most * std::hypot(corner.sigma, weighting_.added_px) ? 1 : 0;
      changed = changed || used != weighting_.used[v][c];
      weighting_.used[v][c] = used;
    });
    return changed;
  }

  [[nodiscard]] double chi_square(double added_px) const {
    double sum = 0;
    each_corner(views_, [&](std::size_t v, std::size_t c, const ViewCorner& corner) {
      if (weighting_.used[v][c] != 0)
        sum += residuals_[v][c].squaredNorm() / (corner.sigma * corner.sigma + added_px * added_px);
    });
    return sum;
  }
  [[nodiscard]] int used_corners() const {
    int n = 0;
    for (const auto& view : weighting_.used) n += static_cast<int>(std::count(view.begin(), view.end(), char{1}));
    return n;
  }
  // A free board's corners count as far as the views, and not the prior, determine them: at most all of their numbers.
  [[nodiscard]] int freedom() const {
    const int lens = static_cast<int>(state_.intrinsics.size()), poses = kPose * static_cast<int>(views_.size());
    int board = 0;
    if (now_.surface == Surface::kBent) board = kBend;
    if (now_.surface == Surface::kFree) board = 3 * static_cast<int>(state_.points.size()) - 7;
    return 2 * used_corners() - lens - poses - board;
  }

  // The deviation that is missing (Paule and Mandel, J. Res. NBS 87 (1982) 377): where the residuals are larger than
  // the corners' own deviations explain by more than chance.
  void weigh() {
    const double n = freedom();
    if (n < 1) return;
    const double most = n + 4 * std::sqrt(2 * n);
    if (chi_square(0) <= most) {
      weighting_.added_px = 0;
      return;
    }
    double low = 0, high = kMaxAddedPx;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      (chi_square(middle) > n ? low : high) = middle;
    }
    weighting_.added_px = high;
  }

  Outcome<CameraFit> result() {
    CameraFit fit;
    fit.freedom = freedom();
    if (fit.freedom < 1)
      return Problem{Exit::kInput,
                     "do not determine a camera",
                     "the corners",
                     "more corners than half the parameters, of " + std::to_string(2 * used_corners() - fit.freedom),
                     std::to_string(used_corners()) + " corners",
                     "more views, or fewer coefficients"};
    const auto problem = make_problem(shape_, views_, now_, weighting_, state_);
    const auto spread = covariance(*problem, blocks_of(state_, now_.surface));
    if (!spread)
      return Problem{Exit::kInput,
                     "do not determine the camera",
                     "the views",
                     "views from which every parameter follows",
                     "at least one parameter that any value fits",
                     "tilt the board by 20 to 45 degrees, each time another way, or use fewer coefficients"};
    fit.chi_square = chi_square(weighting_.added_px);
    fit.variance_factor = fit.chi_square / fit.freedom;
    fit.stated_ratio = std::sqrt(chi_square(0) / fit.freedom);
    fit.added_px = weighting_.added_px;
    const Influences influence = influences(shape_, views_, now_, weighting_, state_, fit.variance_factor);
    fit.view_factor = influence.factor;
    fit.views_contradict = influence.factor > influence.significant;
    fit.covariance = fit.variance_factor * (fit.views_contradict ? fit.view_factor : 1.0) * spread->matrix;
    fit.weakness = spread->weakness.least;
    fit.intrinsics = state_.intrinsics;
    fit.surface = now_.surface;
    fit.bend = state_.bend;
    fit.points = state_.points;
    if (fit.points.empty())
      for (int row = 0; row < shape_.rows; ++row)
        for (int column = 0; column < shape_.columns; ++column) fit.points.push_back(shape_.bent(row, column, state_.bend));
    fit.iterations = iterations_;
    double all = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      ViewFit& view = fit.views.emplace_back();
      view.pose = state_.poses[v];
      view.residuals = residuals_[v];
      view.used = weighting_.used[v];
      view.share = influence.views[v].share;
      view.contradiction = influence.views[v].contradiction;
      view.moved = influence.views[v].moved;
      double sum = 0;
      int n = 0;
      for (std::size_t c = 0; c < view.used.size(); ++c) {
        if (view.used[c] == 0) continue;
        sum += view.residuals[c].squaredNorm();
        ++n;
      }
      view.rms_px = n > 0 ? std::sqrt(sum / (2 * n)) : 0;
      all += sum;
      fit.used += n;
      fit.rejected += static_cast<int>(view.used.size()) - n;
    }
    fit.rms_px = std::sqrt(all / (2 * fit.used));
    return fit;
  }

  const BoardShape shape_;
  const std::vector<BoardView>& views_;
  const CameraOptions options_;
  CameraOptions now_;
  CameraState state_;
  Weighting weighting_;
  Residuals residuals_;
  int iterations_ = 0;
};

}  // namespace

double CameraFit::deviation(int parameter) const { return std::sqrt(covariance(parameter, parameter)); }

Outcome<CameraFit> solve_camera(const BoardShape& shape, const std::vector<BoardView>& views, int image_width, int image_height,
                                const CameraOptions& options) {
  if (!is_coefficient_count(options.coefficients) || views.empty())
    return Problem{
        Exit::kUsage, "cannot be calibrated", "the camera", "4, 5, 8, 12 or 14 coefficients and at least one view", "", ""};
  for (const BoardView& view : views)
    if (view.corners.size() < 4)
      return Problem{Exit::kInput,         "has too few corners", view.name, "at least 4", std::to_string(view.corners.size()),
                     "leave the image out"};
  auto start = start_camera(shape, views, image_width, image_height, options.coefficients);
  if (!start) return start.error();
  return Solver(shape, views, options, std::move(*start)).run();
}

}  // namespace srd::bundle
