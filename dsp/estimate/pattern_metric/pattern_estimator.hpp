// SPDX-License-Identifier: Apache-2.0
// Surface coefficients from all pixels of a region, without corners: the pattern metric (12). Coarse to fine in the blur,
// then with the blur itself as an unknown. One to four cameras jointly. estimate() neither allocates nor throws nor reads a
// clock. One thread per object.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "dsp/core/result.hpp"
#include "dsp/estimate/estimator/estimate.hpp"
#include "dsp/estimate/pattern_metric/pattern_views.hpp"

namespace srd::dsp {

struct PatternOptions {
  bool gradients = true;                // levels may change linearly over the region: lighting
  int max_iterations = 0;               // of the last stage; 0: 50
  double epsg = 0, epsf = 0, epsx = 0;  // of the last stage; all 0: defaults 1e-9 of each kind
  std::vector<double> scale;            // typical size of each coefficient (empty: 1), as EstimatorOptions
};

struct PatternEstimate {
  // mean_error, cost, variance_factor: in grey levels (of several cameras: of the first one's noise). corners_used: pixels. reprojection_rms: 0. at_bound: a blur is at
  // one of its bounds (0.25 px, a fifth of a square), which says that the form of the surface does not fit. information
  // and standard_deviation: sandwich (12c) over blocks of half a square, so that print, dirt and model errors which
  // neighbouring pixels share are counted.
  Estimate<double> surface;
  struct Image {
    double blur_px = 0;  // sigma, pixel's area included
    PatternLevels levels;
  };
  std::array<Image, kMaxPatternViews> images{};
  // 1 - squares / squares about the best plane of grey levels: 1 perfect, 0 no better than no pattern.
  double explained = 0;
  int pixels = 0;  // of all cameras
};

struct PatternView {
  View<double> view;
  Region region;  // of every image of this camera, at least 8 x 8 px
};

class PatternEstimator {
 public:
  // views: 1 to 4; surface.parameters() + views <= 24; options.scale empty or one number a parameter, > 0. kInvalidArgument
  // else.
  [[nodiscard]] static Result<PatternEstimator> make(std::span<const PatternView> views, const PatternSurface& surface,
                                                     const Media<double>& media, const CheckerPlane& plane,
                                                     const PatternOptions& options);

  // images of one moment, one a camera; masks: empty, or one a camera as PatternProblem::load takes it. starts: one or more;
  // the one that explains most through the coarse blur is refined. A start finds the surface when the pattern it predicts
  // lies within 0.4 squares of the image's along each axis; the pattern repeats, so one that is off by whole squares ends
  // there. Stop: kTooFewCorners: fewer pixels than 10 an unknown, or a camera without any. kOutOfDomain: even images, or no
  // start shows the pattern in its own colours.
  [[nodiscard]] PatternEstimate estimate(std::span<const GrayView> images, std::span<const std::span<const std::uint8_t>> masks,
                                         std::span<const Coefficients<double>> starts);

  [[nodiscard]] const PatternSurface& surface() const { return views_.surface(); }

 private:
  PatternEstimator(PatternViews views, const PatternOptions& options) : views_(std::move(views)), options_(options) {}
  [[nodiscard]] int choose_start(std::span<const Coefficients<double>> starts, double& explained);
  [[nodiscard]] Stop refine(Coefficients<double>& a, PatternEstimate& out);

  PatternViews views_;
  PatternOptions options_;
};

}  // namespace srd::dsp
