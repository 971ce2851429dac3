// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/disagreement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace srd::host {
namespace {

constexpr double kFarOutside = 10;  // standard deviations: an instant that waves and noise do not explain
// Block means vary at least as if this share of an instant's variance were common to the block.
constexpr double kLeastShare = 0.01;

}  // namespace

double normal_equivalent(double x, int n) {
  const double spread = 2.0 / (9.0 * n);
  return (std::cbrt(x / n) - (1 - spread)) / std::sqrt(spread);
}

bool Disagreement::add(std::int64_t time_ns, const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = difference.size();
  if (root_.rows() != n) {
    *this = Disagreement{};
    const Eigen::LLT<Eigen::MatrixXd> factored(covariance);
    if (factored.info() != Eigen::Success) return true;
    root_ = factored.matrixL();
    mean_ = squares_ = sum_ = Eigen::VectorXd::Zero(n);
    block_begin_ = time_ns;
  }
  const Eigen::VectorXd white = root_.triangularView<Eigen::Lower>().solve(difference);
  if (!white.allFinite()) return false;
  if (time_ns - block_begin_ >= kBlock || time_ns < block_begin_) {
    close_block();
    block_begin_ = time_ns;
  }
  sum_ += white;
  ++in_block_;
  if (count_ < kLearning) return true;
  const double square = (white - mean_).squaredNorm() / static_cast<double>(n);
  const bool fits = normal_equivalent(static_cast<double>(n) * square / instant_scale_, static_cast<int>(n)) < kFarOutside;
  if (fits) {
    instants_ = std::min<std::int64_t>(instants_ + 1, 10'000);
    instant_scale_ = std::max(instant_scale_ + (square - instant_scale_) / static_cast<double>(instants_), 1.0);
  }
  return fits;
}

void Disagreement::close_block() {
  if (in_block_ >= kLeastInBlock) recent_.push_back(sum_ / in_block_);
  sum_.setZero();
  in_block_ = 0;
  if (recent_.size() <= static_cast<std::size_t>(kRecent)) return;
  // Only what has proved to fit is learned from, so that a shift does not become the rule.
  const auto found = shift();
  if (!found || found->significance < 5) {
    count_ = std::min(count_ + 1, kMemory);
    const Eigen::VectorXd step = recent_.front() - mean_;
    mean_ += step / count_;
    squares_ += (step.cwiseProduct(recent_.front() - mean_) - squares_) / count_;
  }
  recent_.pop_front();
}

std::optional<Disagreement::Shift> Disagreement::shift() const {
  if (count_ < kLearning || recent_.size() < static_cast<std::size_t>(kRecent)) return std::nullopt;
  const Eigen::Index n = mean_.size();
  Eigen::VectorXd now = Eigen::VectorXd::Zero(n);
  for (auto each = recent_.end() - kRecent; each != recent_.end(); ++each) now += *each / kRecent;
  double statistic = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    // Few blocks know their own scatter badly.
    const double learned = squares_[j] * (1.0 + 4.0 / count_);
    const double variance = std::max(learned, kLeastShare * instant_scale_) * (1.0 / kRecent + 1.0 / count_);
    const double off = now[j] - mean_[j];
    statistic += off * off / variance;
  }
  Shift out;
  out.significance = normal_equivalent(statistic, static_cast<int>(n));
  out.mm = root_ * (now - mean_);
  return out;
}

void Disagreement::forget_recent() {
  recent_.clear();
  sum_.setZero();
  in_block_ = 0;
}

}  // namespace srd::host
