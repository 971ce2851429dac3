// SPDX-License-Identifier: Apache-2.0
// The model of edges nearly as sharp as a pixel against integrals, rendered corners and differences.
#include "dsp/frontend/sharp_corner.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dsp/frontend/sharp_edge.hpp"
#include "tests/fakes/corner_patch.hpp"

namespace srd::dsp {
namespace {

constexpr double kPixel = 0.28867513459481287;  // sqrt(1/12)

std::int32_t q14(double x) { return static_cast<std::int32_t>(std::lround(x * (1 << 14))); }

// Mean of f over the two boxes of this edge, by Simpson's rule.
template <class F>
double mean_over_boxes(double x, double wide, double narrow, F f) {
  constexpr int kSteps = 200;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const auto weight = [](int k) { return k == 0 || k == kSteps ? 1 : k % 2 == 1 ? 4 : 2; };
      sum += weight(i) * weight(j) * f(x + wide * (i / double{kSteps} - 0.5) + narrow * (j / double{kSteps} - 0.5));
    }
  return sum / (9.0 * kSteps * kSteps);
}

TEST(SharpEdge, IsTheLensesEdgeAveragedOverThePixelWithItsDerivatives) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int k = 0; k < 60; ++k) {
    const double angle = 6.283 * uniform(random), lens = 0.1 + 0.24 * uniform(random), x = 3 * uniform(random) - 1.5;
    const int parts = k % 2 == 0 ? 1 : 4;
    const double nx = std::cos(angle), ny = std::sin(angle), blur = std::sqrt(lens * lens + 1 / 12.0);
    const SharpEdge edge(q14(nx), q14(ny), std::lround(blur * 4096), parts);
    const SharpEdge::Value value = edge.at(std::lround(x * 65536));
    const auto step = [&](double s) { return std::erf(s / (lens * M_SQRT2)); };
    const auto slope = [&](double s) { return std::sqrt(2 / M_PI) / lens * std::exp(-s * s / (2 * lens * lens)); };
    const auto bend = [&](double s) { return -s / (lens * lens) * slope(s); };
    const double a = std::abs(nx) / parts, b = std::abs(ny) / parts;
    EXPECT_NEAR(value.step / 16384.0, mean_over_boxes(x, a, b, step), 6e-4) << angle << ' ' << lens << ' ' << x;
    EXPECT_NEAR(value.slope / 16384.0, blur * mean_over_boxes(x, a, b, slope), 2e-3);
    EXPECT_NEAR(value.bend / 16384.0, blur * blur * mean_over_boxes(x, a, b, bend), 4e-3);
  }
}

TEST(SharpEdge, WithoutBlurAlongTheRowsIsABox) {
  const SharpEdge edge(1 << 14, 0, 1183, 1);
  for (const double x : {-2.0, -0.6, -0.4, -0.1, 0.0, 0.3, 0.45, 0.7})
    EXPECT_NEAR(edge.at(std::lround(x * 65536)).step / 16384.0, std::clamp(2 * x, -1.0, 1.0), 2e-3) << x;
}

SharpCorner corner_of(const fakes::CornerPatch& patch, int centre) {
  SharpCorner corner;
  corner.x = std::lround((patch.u - centre) * 65536);
  corner.y = std::lround((patch.v - centre) * 65536);
  const double other = patch.angle + M_PI / 2 + patch.skew;
  corner.n1 = {q14(std::cos(patch.angle)), q14(std::sin(patch.angle))};
  corner.n2 = {q14(std::cos(other)), q14(std::sin(other))};
  corner.blur_q12 = std::max(std::lround(4096 * std::hypot(patch.blur, kPixel)), 1183L);
  corner.mean_q6 = static_cast<std::int16_t>(std::lround(64 * patch.mean));
  corner.contrast_q8 = static_cast<std::int16_t>(std::lround(256 * patch.contrast));
  corner.sharpening = {static_cast<std::int32_t>(std::lround(4096 * patch.sharpening)),
                       static_cast<std::int32_t>(std::lround(4096 * patch.sharpening_radius))};
  return corner;
}

std::vector<std::uint8_t> window_of(const std::vector<std::uint8_t>& pixels, int size, int centre, const CornerWindow& window) {
  std::vector<std::uint8_t> out;
  for (int k = 0; k < window.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    out.push_back(pixels[static_cast<std::size_t>((centre + window.dv[i]) * size + centre + window.du[i])]);
  }
  return out;
}

TEST(SharpCorner, AtTheTruthLeavesLittleMoreThanTheRoundingOfThePixels) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const CornerWindow& window = corner_window(5);
  for (int k = 0; k < 48; ++k) {
    fakes::CornerPatch patch;
    patch.size = 25;
    patch.contrast = 60;
    patch.angle = k % 3 == 0 ? 0.1 * uniform(random) : 6.283 * uniform(random);
    patch.skew = k % 2 == 0 ? 0 : 0.3 * uniform(random);
    patch.blur = 0.1 * (k % 4);
    patch.sharpening = 0.5 * (k / 4 % 4);
    patch.sharpening_radius = 0.7 + 0.6 * (k / 16 % 3);
    patch.u = 12 + uniform(random);
    patch.v = 12 + uniform(random);
    const auto pixels = window_of(fakes::render(patch, random), patch.size, 12, window);
    CornerSums sums;
    sharp_corner_sums(window, pixels.data(), corner_of(patch, 12), sums);
    const double square = static_cast<double>(sums.product[CornerSums::kResidual][CornerSums::kResidual]) / window.size;
    EXPECT_LT(std::sqrt(square) / 32, 0.45) << patch.blur << ' ' << patch.sharpening << ' ' << patch.skew << ' ' << patch.angle;
  }
}

// Sums of columns against differences of sums of the residual. The corner lies off the middle, or they would cancel.
TEST(SharpCorner, ColumnsAreTheModelsDerivatives) {
  const CornerWindow& window = corner_window(5);
  const std::vector<std::uint8_t> grey(CornerWindow::kRoom, 128);
  for (const double sharpening : {0.0, 1.0})
    for (const double angle : {0.4, 1.0, 2.2}) {
      fakes::CornerPatch patch;
      patch.blur = 0.25;
      patch.contrast = 60;
      patch.angle = angle;
      patch.u = 1.7;
      patch.v = -2.2;
      patch.sharpening = sharpening;
      const auto sums_at = [&](double across1, double across2, double turn1, double turn2, double widen) {
        fakes::CornerPatch at = patch;
        at.u += across1 * std::cos(angle) - across2 * std::sin(angle);
        at.v += across1 * std::sin(angle) + across2 * std::cos(angle);
        at.angle += turn1;
        at.skew += turn2 - turn1;
        at.blur = std::sqrt(std::pow(std::hypot(at.blur, kPixel) * (1 + widen), 2) - 1 / 12.0);
        CornerSums sums;
        sharp_corner_sums(window, grey.data(), corner_of(at, 0), sums);
        return sums;
      };
      const CornerSums sums = sums_at(0, 0, 0, 0, 0);
      const double blur = std::hypot(patch.blur, kPixel);
      // Of the model in grey levels, from what the residual loses.
      const auto change = [&](const CornerSums& less, const CornerSums& more, double step) {
        const auto of = [](const CornerSums& s) {
          return static_cast<double>(s.product[CornerSums::kMean][CornerSums::kResidual]) / (1 << 16);
        };
        return (of(less) - of(more)) / (2 * step);
      };
      const auto column = [&](CornerSums::Column which) {
        return patch.contrast * static_cast<double>(sums.product[CornerSums::kMean][which]) /
               (1 << (11 + CornerSums::kQ[static_cast<std::size_t>(which)]));
      };
      const auto expect = [&](CornerSums::Column which, double factor, double difference) {
        EXPECT_NEAR(factor * column(which), difference, 0.03 * std::abs(difference) + 12) << which << ' ' << angle;
      };
      constexpr double kStep = 0.02;
      expect(CornerSums::kMove1, -1 / blur, change(sums_at(-kStep, 0, 0, 0, 0), sums_at(kStep, 0, 0, 0, 0), kStep));
      expect(CornerSums::kMove2, -1 / blur, change(sums_at(0, -kStep, 0, 0, 0), sums_at(0, kStep, 0, 0, 0), kStep));
      expect(CornerSums::kTurn1, 1 / blur, change(sums_at(0, 0, -kStep, 0, 0), sums_at(0, 0, kStep, 0, 0), kStep));
      expect(CornerSums::kTurn2, 1 / blur, change(sums_at(0, 0, 0, -kStep, 0), sums_at(0, 0, 0, kStep, 0), kStep));
      expect(CornerSums::kBlur, -1, change(sums_at(0, 0, 0, 0, -kStep), sums_at(0, 0, 0, 0, kStep), kStep));
    }
}

}  // namespace
}  // namespace srd::dsp
