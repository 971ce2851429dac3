// SPDX-License-Identifier: Apache-2.0
// Corners of sharp, soft and sharpened edges, against the bound of their own images.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <ostream>

#include "dsp/frontend/corner_detector.hpp"
#include "dsp/frontend/sharpening.hpp"
#include "tests/fakes/corner_patch.hpp"

namespace srd::dsp {
namespace {

using fakes::CornerPatch;

constexpr int kWindow = CornerFitOptions{}.half_window, kCentre = 12, kSide = 2 * kCentre + 1;

// Levels as the camera delivers them, without noise and rounding.
std::vector<double> exact_levels(const CornerPatch& patch) {
  const int rim = patch.sharpening > 0 ? static_cast<int>(std::ceil(3.5 * patch.sharpening_radius)) : 0;
  std::vector<double> levels = fakes::render_levels(patch, rim);
  if (rim > 0) levels = fakes::unsharp_mask(levels, patch.size + 2 * rim, rim, patch.sharpening, patch.sharpening_radius);
  for (double& level : levels) level = std::clamp(level, 0.0, 255.0);
  return levels;
}

// What of the window's levels changes with something of the patch: by central differences.
template <class Change>
Eigen::VectorXd derivative(const CornerPatch& patch, double step, Change change) {
  CornerPatch less = patch, more = patch;
  change(less, -step);
  change(more, step);
  const auto a = exact_levels(less), b = exact_levels(more);
  Eigen::VectorXd all((2 * kWindow + 1) * (2 * kWindow + 1));
  Eigen::Index k = 0;
  for (int row = kCentre - kWindow; row <= kCentre + kWindow; ++row)
    for (int column = kCentre - kWindow; column <= kCentre + kWindow; ++column, ++k) {
      const auto i = static_cast<std::size_t>(row * patch.size + column);
      all[k] = (b[i] - a[i]) / (2 * step);
    }
  return all;
}

// The least variance of an axis, px^2: of a corner of which all else is known, or of one whose levels, edges and blur must be
// found from the same pixels. Rounding to whole grey levels is noise of 1/12.
double least_variance(const CornerPatch& patch, bool all_unknown) {
  Eigen::MatrixXd by((2 * kWindow + 1) * (2 * kWindow + 1), all_unknown ? 7 : 2);
  by.col(0) = derivative(patch, 0.02, [](CornerPatch& p, double step) { p.u += step; });
  by.col(1) = derivative(patch, 0.02, [](CornerPatch& p, double step) { p.v += step; });
  if (all_unknown) {
    by.col(2) = derivative(patch, 0.005, [](CornerPatch& p, double step) {
      p.angle += step;
      p.skew -= step;
    });
    by.col(3) = derivative(patch, 0.005, [](CornerPatch& p, double step) { p.skew += step; });
    by.col(4) = derivative(patch, 1, [](CornerPatch& p, double step) { p.mean += step; });
    by.col(5) = derivative(patch, 1, [](CornerPatch& p, double step) { p.contrast += step; });
    by.col(6) =
        derivative(patch, 0.01, [](CornerPatch& p, double step) { p.blur = std::sqrt(std::max(p.blur * p.blur + step, 0.0)); });
  }
  const Eigen::MatrixXd covariance = (by.transpose() * by).inverse() * (patch.noise * patch.noise + 1 / 12.0);
  return (covariance(0, 0) + covariance(1, 1)) / 2;
}

struct Edge {
  double blur, sharpening, radius, contrast, noise;
  double degrees = 360;  // off the pixels' rows and columns, at most
};

void PrintTo(const Edge& e, std::ostream* out) {
  *out << "blur " << e.blur << " mask " << e.sharpening << " of radius " << e.radius << " contrast " << 2 * e.contrast
       << " noise " << e.noise << " within " << e.degrees << " degrees";
}

struct Scatter {
  double rms = 0, stated = 0, bound = 0;  // px per axis, root mean squares
  double found = 0;                       // part of all
};

// The model is told how the image was sharpened.
Scatter scatter_of(const Edge& edge, int draws, bool all_unknown) {
  CornerPatch patch;
  patch.size = kSide;
  patch.blur = edge.blur;
  patch.sharpening = edge.sharpening;
  patch.sharpening_radius = edge.radius;
  patch.contrast = edge.contrast;
  patch.noise = edge.noise;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  CornerFitOptions options;
  options.sharpening = {static_cast<std::int32_t>(std::lround(4096 * patch.sharpening)),
                        static_cast<std::int32_t>(std::lround(4096 * patch.sharpening_radius))};
  Scatter s;
  double variance = 0;
  int bounds = 0, found = 0;
  for (int k = 0; k < draws; ++k) {
    patch.angle = M_PI / 2 * (k % 4) + M_PI / 180 * 2 * edge.degrees * uniform(random);
    patch.u = kCentre + uniform(random);
    patch.v = kCentre + uniform(random);
    const auto pixels = fakes::render(patch, random);
    const GrayView image = fakes::view(pixels, patch.size);
    if (all_unknown || k % 4 == 0) {
      variance += least_variance(patch, all_unknown);
      ++bounds;
    }
    CornerShape start;
    CornerFit fit;
    if (!guess_shape(image, static_cast<int>(std::lround(patch.u)), static_cast<int>(std::lround(patch.v)), 5, start) ||
        !fit_corner(image, start, options, fit))
      continue;
    const double du = fit.corner.u.to<double>() - patch.u, dv = fit.corner.v.to<double>() - patch.v;
    s.rms += du * du + dv * dv;
    s.stated += std::pow(fit.corner.sigma_q12 / 4096.0, 2);
    ++found;
  }
  s.rms = std::sqrt(s.rms / (2 * found));
  s.stated = std::sqrt(s.stated / found);
  s.bound = std::sqrt(variance / bounds);
  s.found = static_cast<double>(found) / draws;
  std::printf("%.4f px rms, %.2f of the bound, stated %.2f of it\n", s.rms, s.rms / s.bound, s.stated / s.rms);
  return s;
}

class CornerFitOfEdges : public testing::TestWithParam<Edge> {};

// 200 corners give 400 errors: their rms is known to 3.5 %.
TEST_P(CornerFitOfEdges, IsNearTheBoundAndStatesItsScatter) {
  const Scatter s = scatter_of(GetParam(), 200, false);
  EXPECT_GE(s.found, 0.99);
  EXPECT_LE(s.rms, 1.15 * s.bound);
  EXPECT_NEAR(s.stated / s.rms, 1, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Lens, CornerFitOfEdges,
                         testing::Values(Edge{0, 0, 1, 35, 1}, Edge{0, 0, 1, 70, 2}, Edge{0, 0, 1, 100, 1},
                                         Edge{0, 0, 1, 100, 4}, Edge{0.1, 0, 1, 70, 2}, Edge{0.2, 0, 1, 100, 1},
                                         Edge{0.3, 0, 1, 70, 2}, Edge{0.4, 0, 1, 70, 2}, Edge{2.5, 0, 1, 70, 2},
                                         Edge{4, 0, 1, 70, 2}));
INSTANTIATE_TEST_SUITE_P(Sharpened, CornerFitOfEdges,
                         testing::Values(Edge{0, 0.5, 1, 70, 2}, Edge{0, 1, 1, 70, 2}, Edge{0, 1.5, 1, 35, 1},
                                         Edge{0, 1.5, 1, 35, 4}, Edge{0.1, 0.5, 1, 100, 1}, Edge{0.1, 1, 0.7, 70, 2},
                                         Edge{0.2, 1.5, 1, 70, 1}, Edge{0.2, 1, 2, 70, 2}, Edge{0.3, 0.5, 1, 70, 2},
                                         Edge{0.3, 1.5, 1, 70, 2}, Edge{0.5, 1, 1, 70, 2}, Edge{0.5, 1.5, 0.7, 70, 2},
                                         Edge{0.5, 1, 2, 70, 2}, Edge{0.9, 0.5, 1, 70, 2}, Edge{0.9, 1.5, 1.5, 70, 2},
                                         Edge{2, 1.5, 1, 100, 1}, Edge{4, 1.5, 1, 70, 2}));
INSTANTIATE_TEST_SUITE_P(AlongTheRows, CornerFitOfEdges,
                         testing::Values(Edge{0, 0, 1, 35, 4, 5}, Edge{0, 0, 1, 70, 2, 5}, Edge{0, 0, 1, 100, 1, 5},
                                         Edge{0.1, 0, 1, 100, 1, 5}, Edge{0.2, 0, 1, 70, 2, 5}, Edge{0.3, 0, 1, 100, 1, 5},
                                         Edge{0, 0.5, 1, 70, 2, 5}, Edge{0, 1.5, 1, 35, 1, 5}, Edge{0.2, 1, 1, 70, 2, 5},
                                         Edge{0.3, 1.5, 1, 35, 1, 5}));

class CornerFitOfEdgesThatHideTheirBlur : public testing::TestWithParam<Edge> {};

// Where black and white cut the overshoot off, or edges lie along the rows, few pixels show the blur, and not to know it costs what
// it costs: the bound is that of all unknowns.
TEST_P(CornerFitOfEdgesThatHideTheirBlur, IsNearTheBoundOfWhatTheirPixelsShow) {
  const Scatter s = scatter_of(GetParam(), 160, true);
  EXPECT_GE(s.found, 0.985);
  EXPECT_LE(s.rms, 1.15 * s.bound);
  EXPECT_NEAR(s.stated / s.rms, 1, 0.2);
}

INSTANTIATE_TEST_SUITE_P(AlongTheRows, CornerFitOfEdgesThatHideTheirBlur,
                         testing::Values(Edge{0, 0, 1, 70, 2, 0.5}, Edge{0, 0, 1, 100, 1, 1}, Edge{0, 1, 1, 70, 2, 1}));
INSTANTIATE_TEST_SUITE_P(CutOff, CornerFitOfEdgesThatHideTheirBlur, testing::Values(Edge{0, 1.5, 1, 100, 4}));

// No blur at all and hardly any noise is the worst there is: which pixels count changes with the blur.
TEST(CornerFitOfEdgesThatAreCutOff, IsWithinAHalfOfTheBoundOfWhatTheirPixelsShow) {
  for (const double degrees : {360, 5}) {
    const Scatter s = scatter_of({0, 1.5, 1, 100, 1, degrees}, 120, true);
    EXPECT_GE(s.found, 0.99);
    EXPECT_LE(s.rms, 1.5 * s.bound);
    EXPECT_GE(s.stated, 0.75 * s.rms);
  }
}

// A board of patches, each with a corner of its own phase.
struct Patches {
  static constexpr int kPatch = 41, kColumns = 6, kRows = 5;
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(kPatch * kPatch * kColumns * kRows));
  Patches(CornerPatch patch, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    for (int k = 0; k < kColumns * kRows; ++k) {
      patch.angle = 0.6 * uniform(random) + 0.4;
      patch.u = 20 + uniform(random);
      patch.v = 20 + uniform(random);
      const auto one = fakes::render(patch, random);
      for (int row = 0; row < kPatch; ++row)
        std::copy_n(one.begin() + row * kPatch, kPatch,
                    pixels.begin() + ((k / kColumns * kPatch + row) * kColumns + k % kColumns) * kPatch);
    }
  }
  [[nodiscard]] GrayView view() const { return {pixels.data(), kPatch * kColumns, kPatch * kRows, kPatch * kColumns}; }
};

TEST(SharpeningOfAnImage, IsMeasuredFromItsCornersBesideOthers) {
  for (const double amount : {0.5, 1.0, 1.5})
    for (const double radius : {0.8, 1.5}) {
      CornerPatch patch;
      patch.contrast = 60;
      patch.noise = 2;
      patch.blur = 0.4;
      patch.sharpening = amount;
      patch.sharpening_radius = radius;
      const Patches patches(patch, 3);
      std::vector<CornerShape> starts;
      for (int k = 0; k < Patches::kColumns * Patches::kRows; ++k) {
        CornerShape start;
        const int u = k % Patches::kColumns * Patches::kPatch + 20, v = k / Patches::kColumns * Patches::kPatch + 20;
        ASSERT_TRUE(guess_shape(patches.view(), u, v, 5, start));
        starts.push_back(start);
        if (k % 6 == 0) {  // in a flat place beside the corner
          start.u = Pixel::from_int(u + 9);
          start.v = Pixel::from_int(v + 4);
          starts.push_back(start);
        }
      }
      const Sharpening measured = measure_sharpening(patches.view(), starts, {});
      EXPECT_NEAR(measured.amount_q12 / 4096.0, amount, 0.2 * amount);
      EXPECT_NEAR(measured.radius_q12 / 4096.0, radius, 0.2 * radius);
    }
}

TEST(CornerDetectorOfSharpenedImages, TakesNoSharpLensForASharpeningCamera) {
  for (const double blur : {0.1, 0.3, 0.5, 0.9}) {
    CornerPatch patch;
    patch.noise = 2;
    patch.blur = blur;
    const Patches patches(patch, 5);
    CornerDetector detector(400, 400, 500);
    EXPECT_GE(detector.detect(patches.view(), {}).size(), 30u) << blur;
    EXPECT_EQ(detector.sharpening(), Sharpening{}) << blur;
  }
}

TEST(CornerDetectorOfSharpenedImages, KeepsTheSharpeningThatItIsGiven) {
  CornerPatch patch;
  patch.contrast = 60;
  patch.blur = 0.4;
  patch.sharpening = 1;
  const Patches patches(patch, 9);
  CornerDetector detector(400, 400, 500);
  DetectorOptions options;
  options.measure_sharpening = false;
  options.fit.sharpening = {4096, 4096};
  EXPECT_GE(detector.detect(patches.view(), options).size(), 30u);
  EXPECT_EQ(detector.sharpening(), options.fit.sharpening);
}

}  // namespace
}  // namespace srd::dsp
