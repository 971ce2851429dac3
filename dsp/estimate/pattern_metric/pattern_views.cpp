// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/pattern_metric/pattern_views.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {

int PatternViews::load(std::span<const GrayView> images, std::span<const std::span<const std::uint8_t>> masks) {
  if (images.size() != problems_.size() || (!masks.empty() && masks.size() != problems_.size())) return 0;
  for (std::size_t i = 0; i < problems_.size(); ++i)
    if (problems_[i].load(images[i], masks.empty() ? std::span<const std::uint8_t>{} : masks[i]) == 0) return 0;
  // Grey levels of a bright and of a dim image tell the same of the surface.
  const auto variance = [&](std::size_t i) { return problems_[i].squares_without_pattern() / problems_[i].n_pixels(); };
  for (std::size_t i = 0; i < problems_.size(); ++i) weight_[i] = variance(i) > 0 ? variance(0) / variance(i) : 1;
  return n_pixels();
}

bool PatternViews::start_from(const Coefficients<double>& a) {
  return std::all_of(problems_.begin(), problems_.end(), [&](PatternProblem& each) { return each.start_from(a); });
}

void PatternViews::thin(double pixels_a_square) {
  for (PatternProblem& each : problems_)
    each.thin(pixels_a_square > 0 ? std::max(1, static_cast<int>(each.square_px() / pixels_a_square)) : 1);
}

void PatternViews::hold_blur(double squares) {
  for (PatternProblem& each : problems_) each.hold_blur(squares * each.square_px());
  blur_is_free_ = false;
}

void PatternViews::free_blur() {
  for (PatternProblem& each : problems_) each.free_blur();
  blur_is_free_ = true;
}

Coefficients<double> PatternViews::of_view(const Coefficients<double>& unknowns, int view) const {
  const Eigen::Index n = surface().parameters();
  Coefficients<double> own = unknowns.head(blur_is_free_ ? n + 1 : n);
  if (blur_is_free_) own[n] = unknowns[n + view];
  return own;
}

void PatternViews::add(const NormalEquations& part, int view, NormalEquations& out) const {
  const double weight = weight_[static_cast<std::size_t>(view)];
  const Eigen::Index n = surface().parameters();
  out.jtj.topLeftCorner(n, n) += weight * part.jtj.topLeftCorner(n, n);
  out.jte.head(n) += weight * part.jte.head(n);
  if (blur_is_free_) {
    out.jtj.col(n + view).head(n) += weight * part.jtj.col(n).head(n);
    out.jtj(n + view, n + view) += weight * part.jtj(n, n);
    out.jte[n + view] += weight * part.jte[n];
  }
  out.cost += weight * part.cost;
  out.cost_noise += weight * part.cost_noise;
  out.squares += weight * part.squares;
  out.error += std::sqrt(weight) * part.error;
}

bool PatternViews::evaluate(const Coefficients<double>& unknowns, NormalEquations& out) {
  out.reset(static_cast<int>(unknowns.size()));
  for (int i = 0; i < size(); ++i) {
    if (!problems_[static_cast<std::size_t>(i)].evaluate(of_view(unknowns, i), part_)) return false;
    add(part_, i, out);
  }
  return true;
}

void PatternViews::reweigh() {
  std::array<double, kMaxPatternViews> variance{};
  for (std::size_t i = 0; i < problems_.size(); ++i) variance[i] = std::pow(problems_[i].reweigh(), 2);
  for (std::size_t i = 0; i < problems_.size(); ++i) weight_[i] = variance[0] / variance[i];
}

void PatternViews::sandwich(double block_squares, PatternProblem::Sandwich& out) {
  const Eigen::Index n = surface().parameters(), all = n + size();
  out.bread = out.middle = InformationMatrix<double>::Zero(all, all);
  out.blocks = 0;
  PatternProblem::Sandwich part;
  for (int i = 0; i < size(); ++i) {
    PatternProblem& problem = problems_[static_cast<std::size_t>(i)];
    problem.sandwich(std::max(1, static_cast<int>(std::lround(block_squares * problem.square_px()))), part);
    const double weight = weight_[static_cast<std::size_t>(i)];
    const auto put = [&](const InformationMatrix<double>& from, double scale, InformationMatrix<double>& to) {
      to.topLeftCorner(n, n) += scale * from.topLeftCorner(n, n);
      to.col(n + i).head(n) += scale * from.col(n).head(n);
      to.row(n + i).head(n) += scale * from.row(n).head(n);
      to(n + i, n + i) += scale * from(n, n);
    };
    put(part.bread, weight, out.bread);
    put(part.middle, weight * weight, out.middle);
    out.blocks += part.blocks;
  }
}

int PatternViews::n_pixels() const {
  int sum = 0;
  for (const PatternProblem& each : problems_) sum += each.n_pixels();
  return sum;
}

int PatternViews::n_levels() const { return size() * problems_.front().n_levels(); }

double PatternViews::squares_without_pattern() const {
  double sum = 0;
  for (std::size_t i = 0; i < problems_.size(); ++i) sum += weight_[i] * problems_[i].squares_without_pattern();
  return sum;
}

}  // namespace srd::dsp
