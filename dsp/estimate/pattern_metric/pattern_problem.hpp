// SPDX-License-Identifier: Apache-2.0
// All pixels of a region as the solver's least-squares problem: grey levels predicted from the pattern's black and white
// where each pixel's ray arrives, smoothed by the blur. Optics (12), (12a), (12b). Memory is sized at construction.
// One camera; one thread per object.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/core/image_view.hpp"
#include "dsp/estimate/pattern_metric/blurred_checker.hpp"
#include "dsp/estimate/pattern_metric/pattern_surface.hpp"
#include "dsp/estimate/solver/normal_equations.hpp"

namespace srd::dsp {

// The checkerboard in the plane Z = z, endless: regions must not reach beyond the printed squares.
struct CheckerPlane {
  double square_mm = 0;
  double x = 0, y = 0, z = 0;  // a corner, mm
  bool dark = true;            // the square from that corner towards +X, +Y
};

// Grey levels over the region, linear in the pixel's place (u', v' in -1..1 over the region; optics (12a)):
// level = mean + contrast shape.
struct PatternLevels {
  static constexpr int kMax = 6;
  std::array<double, 3> mean{}, contrast{};  // constant part, by u', by v'
};

class PatternProblem {
 public:
  // region: of the image. gradients: whether levels may change over the region. Pixels that the lens has no ray for, or
  // whose ray does not go down, are left out.
  PatternProblem(const View<double>& view, const Region& region, const PatternSurface& surface, const Media<double>& media,
                 const CheckerPlane& plane, bool gradients);

  // mask: one byte a pixel of the region, row by row, 0: leave out; empty: all are used. The number of pixels used; 0
  // when the image does not hold the region.
  int load(const GrayView& image, std::span<const std::uint8_t> mask);

  // Fixes how the blur lies on the pattern to what it is on the surface a. Needed before evaluate. False: a ray misses
  // the surface or the bottom.
  [[nodiscard]] bool start_from(const Coefficients<double>& a);
  // Of the next evaluations, every so many columns and rows of the region are used: 1 for all. reweigh() and sandwich()
  // need an evaluation of all.
  void thin(int every) { every_ = every; }
  // Blur of the next evaluations: given, or the unknown after the surface's.
  void hold_blur(double blur_px) { held_blur_px_ = blur_px; }
  void free_blur() { held_blur_px_ = 0; }

  // unknowns: the surface's coefficients and, when free, the blur (px). Levels are eliminated exactly: the best ones for
  // these unknowns, and their part of the derivatives projected out (variable projection in Kaufman's form).
  // False: a ray misses the surface, the levels are not determined or the contrast is not positive, blur out of range.
  [[nodiscard]] bool evaluate(const Coefficients<double>& unknowns, NormalEquations& out);

  // Huber's weights for the next evaluations, from the last one's residuals: 1 up to 1.345 deviations, the deviation from
  // their median; beyond, falling with the size. load() makes all weights 1 again. That deviation, grey levels > 0.
  double reweigh();

  // Of the last evaluation, the parts of the sandwich H^-1 M H^-1 (17), levels projected out. middle: residuals of a block
  // of block_px x block_px pixels taken together, because neighbours share print, dirt and model errors. bread: of the
  // pixels that Huber's weights leave whole. blocks: how many hold pixels.
  struct Sandwich {
    InformationMatrix<double> bread, middle;
    int blocks = 0;
  };
  void sandwich(int block_px, Sandwich& out);

  [[nodiscard]] const PatternLevels& levels() const { return levels_; }
  [[nodiscard]] int n_pixels() const { return n_used_; }
  [[nodiscard]] int n_levels() const { return n_levels_; }
  // Squared differences from the best plane of grey levels without any pattern: what a fit is measured against.
  [[nodiscard]] double squares_without_pattern() const { return flat_squares_; }
  // Mean side of a square in the image, px, on the surface of start_from.
  [[nodiscard]] double square_px() const { return square_px_; }
  [[nodiscard]] const PatternSurface& surface() const { return surface_; }

 private:
  struct Pixel {
    Vec3<double> direction;              // in W, unit
    Eigen::Matrix<float, 3, 2> d_pixel;  // by the raw pixel
    float u = 0, v = 0;                  // -1..1
    bool sees = false;
  };
  // One that is used, and what the last evaluation found for it.
  struct Sample {
    int pixel = 0;
    int column = 0, row = 0;  // px, in the region
    double grey = 0;
    double weight = 1;
    double along = 0;  // mm along the ray to the surface
    BlurFootprint blur;
    Vec3<double> surface_point;
    double by_height = 0, by_slope_x = 0, by_slope_y = 0;  // of the shape
    double shape = 0, by_blur = 0;
    bool flat = false;
  };
  using LevelMatrix = Eigen::Matrix<double, PatternLevels::kMax, PatternLevels::kMax>;
  using LevelVector = Eigen::Matrix<double, PatternLevels::kMax, 1>;
  using Coupling = Eigen::Matrix<double, Eigen::Dynamic, PatternLevels::kMax, 0, kMaxModes, PatternLevels::kMax>;

  [[nodiscard]] bool skips(const Sample& sample) const {
    return every_ > 1 && (sample.column % every_ != 0 || sample.row % every_ != 0);
  }
  [[nodiscard]] bool follow(const Coefficients<double>& unknowns, Sample& sample);
  [[nodiscard]] LevelVector regressors(const Sample& sample) const;
  [[nodiscard]] bool solve_levels();
  // Derivatives of the predicted grey level by the unknowns; false where all are 0.
  [[nodiscard]] bool row(const Sample& sample, Coefficients<double>& out);
  [[nodiscard]] double predicted(const Sample& sample) const;

  View<double> view_;
  Region region_;
  PatternSurface surface_;
  Media<double> media_;
  CheckerPlane plane_;
  int n_levels_;
  std::vector<Pixel> pixels_;                 // of the region, row by row
  std::vector<Sample> samples_;               // the first n_used_ count
  std::vector<Coefficients<double>> scores_;  // one a block
  std::vector<float> sizes_;                  // of residuals, for their median
  int n_used_ = 0, n_unknowns_ = 0, every_ = 1;
  double held_blur_px_ = 1, blur_px_ = 1, square_px_ = 0, flat_squares_ = 0;
  PatternLevels levels_;
  LevelMatrix level_inverse_ = LevelMatrix::Zero();
  Coupling coupling_;  // sum of rows times regressors
  Basis<double> basis_;
};

}  // namespace srd::dsp
