// SPDX-License-Identifier: Apache-2.0
// Corners of sharp, soft and sharpened edges, against the bound of their own images.
#include <gtest/gtest.h>

#include <cmath>

#include "dsp/frontend/corner_detector.hpp"
#include "dsp/frontend/sharpening.hpp"
#include "tests/fakes/corner_patch.hpp"

namespace srd::dsp {
namespace {

using fakes::CornerPatch;

constexpr int kWindow = CornerFitOptions{}.half_window;

// Levels as the camera delivers them, without noise and rounding.
std::vector<double> exact_levels(const CornerPatch& patch) {
  if (patch.sharpening <= 0) return fakes::render_levels(patch, 0);
  const int rim = static_cast<int>(std::ceil(3.5 * patch.sharpening_radius));
  return fakes::unsharp_mask(fakes::render_levels(patch, rim), patch.size + 2 * rim, rim, patch.sharpening,
                             patch.sharpening_radius);
}

// The least variance of an axis, px^2, of a corner whose levels, edges and blur are known: from how the window's levels change
// with its place, by central differences.
double least_variance(CornerPatch patch) {
  constexpr double kStep = 0.02;
  const double u = patch.u, v = patch.v;
  const auto at = [&](double du, double dv) {
    patch.u = u + du;
    patch.v = v + dv;
    return exact_levels(patch);
  };
  const auto left = at(-kStep, 0), right = at(kStep, 0), up = at(0, -kStep), down = at(0, kStep);
  double uu = 0, uv = 0, vv = 0;
  for (int row = 20 - kWindow; row <= 20 + kWindow; ++row)
    for (int column = 20 - kWindow; column <= 20 + kWindow; ++column) {
      const auto i = static_cast<std::size_t>(row * patch.size + column);
      const double by_u = (right[i] - left[i]) / (2 * kStep), by_v = (down[i] - up[i]) / (2 * kStep);
      uu += by_u * by_u;
      uv += by_u * by_v;
      vv += by_v * by_v;
    }
  return patch.noise * patch.noise * (uu + vv) / (2 * (uu * vv - uv * uv));
}

struct Scatter {
  double rms = 0, stated = 0, bound = 0;  // px per axis
  int found = 0;
};

// The model is told how the image was sharpened. The board lies at any angle.
Scatter scatter_of(CornerPatch patch, int draws) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  CornerFitOptions options;
  options.sharpening = {static_cast<std::int32_t>(std::lround(4096 * patch.sharpening)),
                        static_cast<std::int32_t>(std::lround(4096 * patch.sharpening_radius))};
  Scatter s;
  double variance = 0;
  int bounds = 0;
  for (int k = 0; k < draws; ++k) {
    patch.angle = M_PI * 2 * uniform(random);
    patch.u = 20 + uniform(random);
    patch.v = 20 + uniform(random);
    const auto pixels = fakes::render(patch, random);
    const GrayView image = fakes::view(pixels, patch.size);
    if (k % 8 == 0) {
      variance += least_variance(patch);
      ++bounds;
    }
    CornerShape start;
    CornerFit fit;
    if (!guess_shape(image, static_cast<int>(std::lround(patch.u)), static_cast<int>(std::lround(patch.v)), 5, start) ||
        !fit_corner(image, start, options, fit))
      continue;
    const double du = fit.corner.u.to<double>() - patch.u, dv = fit.corner.v.to<double>() - patch.v;
    s.rms += du * du + dv * dv;
    s.stated += fit.corner.sigma_q12 / 4096.0;
    ++s.found;
  }
  s.rms = std::sqrt(s.rms / (2 * s.found));
  s.stated /= s.found;
  s.bound = std::sqrt(variance / bounds);
  return s;
}

struct Edge {
  double blur, sharpening, radius;
};

class CornerFitOfEdges : public testing::TestWithParam<Edge> {};

// 160 corners give 320 errors: their rms is known to 4 %.
TEST_P(CornerFitOfEdges, IsNearTheBoundAndStatesItsScatter) {
  CornerPatch patch;
  patch.contrast = 70;
  patch.noise = 2;
  patch.blur = GetParam().blur;
  patch.sharpening = GetParam().sharpening;
  patch.sharpening_radius = GetParam().radius;
  const Scatter s = scatter_of(patch, 160);
  std::printf("blur %.2f, unsharp mask %.1f of radius %.1f: %.4f px rms, %.2f of the bound, stated %.2f of it\n", patch.blur,
              patch.sharpening, patch.sharpening_radius, s.rms, s.rms / s.bound, s.stated / s.rms);
  EXPECT_GE(s.found, 159);
  EXPECT_LE(s.rms, 1.15 * s.bound);
  EXPECT_NEAR(s.stated / s.rms, 1, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Lens, CornerFitOfEdges,
                         testing::Values(Edge{0, 0, 1}, Edge{0.1, 0, 1}, Edge{0.2, 0, 1}, Edge{0.3, 0, 1}, Edge{0.3, 0.5, 1},
                                         Edge{0.3, 1.5, 1}, Edge{0.5, 1, 1}, Edge{0.5, 1.5, 0.7}, Edge{0.5, 1, 2},
                                         Edge{0.9, 0.5, 1}, Edge{0.9, 1.5, 1.5}, Edge{2.5, 0, 1}, Edge{4, 0, 1},
                                         Edge{4, 1.5, 1}));

// No lens is that sharp; images reduced by area come near.
TEST(CornerFitOfPixels, WithoutBlurx) {
  for (const double sharpening : {0.0, 0.5, 1.0}) {
    CornerPatch patch;
    patch.contrast = 70;
    patch.noise = 2;
    patch.blur = 0;
    patch.sharpening = sharpening;
    const Scatter s = scatter_of(patch, 120);
    EXPECT_GE(s.found, 119) << sharpening;
    EXPECT_LT(s.rms, 0.006) << sharpening;
  }
}

// A board of patches, each with a corner of its own phase.
struct Patches {
  static constexpr int kSide = 41, kColumns = 6, kRows = 5;
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(static_cast<std::size_t>(kSide * kSide * kColumns * kRows));
  Patches(CornerPatch patch, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    for (int k = 0; k < kColumns * kRows; ++k) {
      patch.angle = 0.6 * uniform(random) + 0.4;
      patch.u = 20 + uniform(random);
      patch.v = 20 + uniform(random);
      const auto one = fakes::render(patch, random);
      for (int row = 0; row < kSide; ++row)
        std::copy_n(one.begin() + row * kSide, kSide,
                    pixels.begin() + ((k / kColumns * kSide + row) * kColumns + k % kColumns) * kSide);
    }
  }
  [[nodiscard]] GrayView view() const { return {pixels.data(), kSide * kColumns, kSide * kRows, kSide * kColumns}; }
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
        const int u = k % Patches::kColumns * Patches::kSide + 20, v = k / Patches::kColumns * Patches::kSide + 20;
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
