// SPDX-License-Identifier: Apache-2.0
// The pixels of one or more cameras that see one surface at one moment, as one least-squares problem: the surface's
// coefficients are common, blur and grey levels are each camera's own. Optics (12), (12d).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dsp/estimate/pattern_metric/pattern_problem.hpp"

namespace srd::dsp {

inline constexpr int kMaxPatternViews = 4;

class PatternViews {
 public:
  // 1 to 4 problems of the same surface.
  explicit PatternViews(std::vector<PatternProblem> problems) : problems_(std::move(problems)) {
    weight_.fill(1);
    part_.reset(kMaxParameters);
  }

  [[nodiscard]] int size() const { return static_cast<int>(problems_.size()); }
  [[nodiscard]] const PatternProblem& operator[](int view) const { return problems_[static_cast<std::size_t>(view)]; }
  [[nodiscard]] const PatternSurface& surface() const { return problems_.front().surface(); }

  // images, masks: one a camera; masks empty: all pixels, else each as PatternProblem::load takes it. Cameras weigh by their
  // contrast until reweigh() has seen residuals. The number of pixels used; 0 when an image does not hold its region.
  int load(std::span<const GrayView> images, std::span<const std::span<const std::uint8_t>> masks);
  [[nodiscard]] bool start_from(const Coefficients<double>& a);
  // Of the next evaluations: a square is seen by so many pixels a side; 0: by all.
  void thin(double pixels_a_square);
  void hold_blur(double squares);
  void free_blur();
  // unknowns: the surface's coefficients and, when free, the blur (px) of each camera. False: as PatternProblem::evaluate.
  [[nodiscard]] bool evaluate(const Coefficients<double>& unknowns, NormalEquations& out);
  // Huber's weights of the pixels, and cameras weighed by their residuals' variance.
  void reweigh();
  // block_squares: side of a block, in squares.
  void sandwich(double block_squares, PatternProblem::Sandwich& out);

  [[nodiscard]] int n_pixels() const;
  [[nodiscard]] int n_levels() const;
  // Weighed like the cost.
  [[nodiscard]] double squares_without_pattern() const;

 private:
  [[nodiscard]] Coefficients<double> of_view(const Coefficients<double>& unknowns, int view) const;
  void add(const NormalEquations& part, int view, NormalEquations& out) const;

  std::vector<PatternProblem> problems_;
  std::array<double, kMaxPatternViews> weight_;  // of a camera's squares, about 1
  bool blur_is_free_ = false;
  NormalEquations part_;
};

}  // namespace srd::dsp
