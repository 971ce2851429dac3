// SPDX-License-Identifier: Apache-2.0
// Does a board still see what the others see? Its difference to the surface of the others, over seconds, against what that
// difference was before: a camera or a pattern that moves shifts it at once and for good.
//
// Differences of an instant are dominated by what both descriptions leave out of the waves, and have their own scatter; means
// over a second have little of it. Their scatter is measured, not assumed. Of one set of boards: another set has
// other differences. Bounded memory. One thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include <Eigen/Core>

namespace srd::host {

class Disagreement {
 public:
  static constexpr std::int64_t kBlock = 1'000'000'000;  // ns that one mean covers
  static constexpr int kLeastInBlock = 5;
  static constexpr int kRecent = 4;    // blocks that are compared with the ones before
  static constexpr int kLearning = 8;  // blocks before anything is told
  static constexpr int kMemory = 1800;

  // difference: the board's coefficients less what the others say they are, mm; covariance: of its random error, mm^2.
  // True when the instant fits what was learned; false when it lies far outside (or nothing is learned yet: true).
  bool add(std::int64_t time_ns, const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance);

  struct Shift {
    double significance = 0;  // standard deviations of a normal variable that is as unlikely
    Eigen::VectorXd mm;       // of each coefficient
  };
  // The last blocks against the ones before. nullopt: still learning.
  [[nodiscard]] std::optional<Shift> shift() const;
  // The last blocks count no more: what they hold was somebody else's fault.
  void forget_recent();
  // Blocks that were learned from.
  [[nodiscard]] int learned() const { return count_; }

 private:
  void close_block();

  // The block that is filling: sums of whitened differences.
  std::int64_t block_begin_ = 0;
  int in_block_ = 0;
  Eigen::VectorXd sum_;
  // Differences are whitened by the random covariance of the first ones: about one a coefficient.
  Eigen::MatrixXd root_;  // lower triangular
  // Learned: of block means, and of instants.
  int count_ = 0;
  Eigen::VectorXd mean_, squares_;  // Welford's
  double instant_scale_ = 1;        // mean square of an instant's whitened difference about the mean, a coefficient
  std::int64_t instants_ = 0;
  std::deque<Eigen::VectorXd> recent_;
};

// The number of standard deviations of a normal variable that is exceeded as seldom as x by chi-square with n degrees of
// freedom: Wilson and Hilferty, PNAS 17 (1931) 684.
[[nodiscard]] double normal_equivalent(double x, int n);

}  // namespace srd::host
