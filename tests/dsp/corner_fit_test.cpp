// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fakes/corner_patch.hpp"

namespace srd::dsp {
namespace {

using fakes::CornerPatch;

// Lower bound of any estimator, optics (20); patch.contrast is half of the bound's C.
double bound(const CornerPatch& p, int half_window) {
  return p.noise * std::sqrt(2 * std::sqrt(M_PI) * std::sqrt(p.blur * p.blur + 1.0 / 12) / (2 * half_window + 1)) /
         (2 * p.contrast);
}

bool find(const std::vector<std::uint8_t>& pixels, int size, int u, int v, CornerFit& fit) {
  const GrayView image = fakes::view(pixels, size);
  CornerShape start;
  return guess_shape(image, u, v, 5, start) && fit_corner(image, start, CornerFitOptions{}, fit);
}

struct Statistics {
  double rms = 0, stated = 0;  // px per axis
  double bias_u = 0, bias_v = 0;
  int failed = 0, draws = 0;
};

Statistics measure(CornerPatch patch, double skew, int draws, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  Statistics s;
  for (int k = 0; k < draws; ++k) {
    patch.angle = 2 * M_PI * uniform(random);
    patch.skew = 2 * skew * uniform(random);
    patch.u = 20 + uniform(random);
    patch.v = 20 + uniform(random);
    CornerFit fit;
    if (!find(fakes::render(patch, random), patch.size, static_cast<int>(std::lround(patch.u)),
              static_cast<int>(std::lround(patch.v)), fit)) {
      ++s.failed;
      continue;
    }
    const double du = fit.corner.u.to<double>() - patch.u, dv = fit.corner.v.to<double>() - patch.v;
    s.rms += du * du + dv * dv;
    s.bias_u += du;
    s.bias_v += dv;
    s.stated += fit.corner.sigma_q12 / 4096.0;
    ++s.draws;
  }
  s.rms = std::sqrt(s.rms / (2 * s.draws));
  s.stated /= s.draws;
  s.bias_u /= s.draws;
  s.bias_v /= s.draws;
  return s;
}

constexpr double kDegree = M_PI / 180;

TEST(CornerFit, NoiseFreeCornersAreRightToAFewThousandthsOfAPixel) {
  for (const double skew : {0.0, 20.0, 35.0})
    for (const double blur : {0.5, 0.9, 2.0}) {
      CornerPatch patch;
      patch.blur = blur;
      const Statistics s = measure(patch, skew * kDegree, 40, 1);
      EXPECT_EQ(s.failed, 0);
      EXPECT_LT(s.rms, 0.003) << "skew " << skew << " blur " << blur;
    }
}

struct Conditions {
  double blur, noise, contrast, skew, square;
};

class CornerFitUnder : public testing::TestWithParam<Conditions> {};

// 200 corners give 400 errors: their rms is known to 3.5 %.
TEST_P(CornerFitUnder, ScatterIsNearTheBoundAndAsStated) {
  const Conditions c = GetParam();
  CornerPatch patch;
  patch.blur = c.blur;
  patch.noise = c.noise;
  patch.contrast = c.contrast / 2;
  patch.square = c.square;
  const Statistics s = measure(patch, c.skew * kDegree, 200, 5);
  EXPECT_LE(s.failed, 2);
  // The bound is for known levels and blur and square-on edges: a wide blur leaves less of the edges in the window.
  EXPECT_LT(s.rms, bound(patch, 5) * (c.blur > 1.4 ? 1.5 : 1.25));
  EXPECT_GT(s.rms, bound(patch, 5) * 0.85);
  EXPECT_NEAR(s.rms / s.stated, 1, 0.2);
  const double deviation = s.rms / std::sqrt(static_cast<double>(s.draws));
  EXPECT_LT(std::abs(s.bias_u), 4 * deviation);
  EXPECT_LT(std::abs(s.bias_v), 4 * deviation);
}

INSTANTIATE_TEST_SUITE_P(Light, CornerFitUnder,
                         testing::Values(Conditions{0.5, 2, 200, 0, 1e9}, Conditions{0.9, 2, 200, 0, 1e9},
                                         Conditions{2.0, 2, 200, 0, 1e9}, Conditions{0.9, 1, 200, 20, 1e9},
                                         Conditions{0.9, 4, 200, 20, 1e9}, Conditions{0.9, 4, 60, 0, 1e9},
                                         Conditions{0.5, 4, 60, 20, 1e9}, Conditions{2.0, 4, 100, 0, 1e9}));
// Squares so small that other edges come into the window are near everywhere, which takes the rendering ten times as long.
INSTANTIATE_TEST_SUITE_P(SlowLight, CornerFitUnder,
                         testing::Values(Conditions{0.9, 2, 200, 20, 14}, Conditions{1.5, 2, 120, 10, 14}));

// A lamp at one side: 40 % over 1280 px.
TEST(CornerFit, LightingGradientMovesACornerLessThanAFiftiethOfAPixel) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int k = 0; k < 50; ++k) {
    CornerPatch patch;
    patch.u = 20 + uniform(random);
    patch.v = 20 + uniform(random);
    patch.angle = 6 * uniform(random);
    auto pixels = fakes::render(patch, random);
    for (int i = 0; i < patch.size * patch.size; ++i) {
      auto& pixel = pixels[static_cast<std::size_t>(i)];
      pixel = static_cast<std::uint8_t>(std::lround(pixel * (1 + 0.4 * (i % patch.size - 20) / 1280.0)));
    }
    CornerFit fit;
    ASSERT_TRUE(find(pixels, patch.size, 20, 20, fit));
    EXPECT_LT(std::hypot(fit.corner.u.to<double>() - patch.u, fit.corner.v.to<double>() - patch.v), 0.02);
  }
}

TEST(CornerFit, SaturatedLevelsMoveACornerLessThanATwentiethOfAPixel) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int k = 0; k < 30; ++k) {
    CornerPatch patch;
    patch.mean = 180;  // bright would be 300
    patch.contrast = 120;
    patch.u = 20 + uniform(random);
    patch.v = 20 + uniform(random);
    patch.angle = 6 * uniform(random);
    CornerFit fit;
    ASSERT_TRUE(find(fakes::render(patch, random), patch.size, 20, 20, fit));
    EXPECT_NEAR(fit.corner.u.to<double>(), patch.u, 0.05);
    EXPECT_NEAR(fit.corner.v.to<double>(), patch.v, 0.05);
  }
}

TEST(CornerFit, ShiftingTheImageByWholePixelsShiftsTheCornerExactly) {
  std::mt19937 random(9);
  CornerPatch patch;
  patch.noise = 3;
  patch.u = 19.3;
  patch.v = 20.2;
  const auto pixels = fakes::render(patch, random);
  const GrayView whole = fakes::view(pixels, 41);
  const GrayView moved{whole.row(2) + 3, 36, 36, whole.stride_bytes};
  CornerShape start, moved_start;
  CornerFit fit, moved_fit;
  ASSERT_TRUE(guess_shape(whole, 19, 20, 5, start));
  ASSERT_TRUE(guess_shape(moved, 16, 18, 5, moved_start));
  ASSERT_TRUE(fit_corner(whole, start, CornerFitOptions{}, fit));
  ASSERT_TRUE(fit_corner(moved, moved_start, CornerFitOptions{}, moved_fit));
  EXPECT_EQ(fit.corner.u.raw() - moved_fit.corner.u.raw(), 3 << 12);
  EXPECT_EQ(fit.corner.v.raw() - moved_fit.corner.v.raw(), 2 << 12);
}

TEST(CornerFit, RefusesTheOtherPolarity) {
  std::mt19937 random(1);
  const CornerPatch patch;
  const auto pixels = fakes::render(patch, random);
  CornerShape start;
  CornerFit fit;
  ASSERT_TRUE(guess_shape(fakes::view(pixels, 41), 20, 20, 5, start));
  ASSERT_TRUE(fit_corner(fakes::view(pixels, 41), start, CornerFitOptions{}, fit));
  start.n2 = {-start.n2.x, -start.n2.y};
  EXPECT_FALSE(fit_corner(fakes::view(pixels, 41), start, CornerFitOptions{}, fit));
}

TEST(CornerFit, RefusesWhatIsNoCorner) {
  const CornerShape start{Pixel::from_int(20), Pixel::from_int(20), {16384, 0}, {0, 16384}, 4096};
  std::vector<std::uint8_t> flat(41 * 41, 100), edge(41 * 41), spot(41 * 41, 30), noise(41 * 41);
  std::mt19937 random(11);
  for (int i = 0; i < 41 * 41; ++i) {
    const auto k = static_cast<std::size_t>(i);
    edge[k] = i % 41 < 20 ? 20 : 220;
    if (std::hypot(i % 41 - 20, i / 41 - 20) < 4) spot[k] = 255;
    noise[k] = static_cast<std::uint8_t>(random());
  }
  for (const auto* pixels : {&flat, &edge, &spot, &noise}) {
    CornerFit fit;
    EXPECT_FALSE(fit_corner(fakes::view(*pixels, 41), start, CornerFitOptions{}, fit));
    EXPECT_FALSE(find(*pixels, 41, 20, 20, fit));
  }
}

TEST(CornerFit, RefusesWindowsThatLeaveTheImage) {
  std::mt19937 random(1);
  CornerPatch patch;
  patch.u = patch.v = 4;
  const auto pixels = fakes::render(patch, random);
  const CornerShape start{Pixel::from_int(4), Pixel::from_int(4), {16384, 0}, {0, 16384}, 4096};
  CornerFit fit;
  CornerShape guess;
  EXPECT_FALSE(guess_shape(fakes::view(pixels, 41), 4, 4, 5, guess));
  EXPECT_FALSE(fit_corner(fakes::view(pixels, 41), start, CornerFitOptions{}, fit));
}

}  // namespace
}  // namespace srd::dsp
