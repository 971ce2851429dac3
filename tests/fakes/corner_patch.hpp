// SPDX-License-Identifier: Apache-2.0
// A checkerboard corner as a camera sees it: the mean of a two-dimensional square wave over the lens's normal distribution (exact
// for straight edges: integrated along one normal with the error function along the other), averaged over each pixel's area;
// then, where the camera sharpens, an unsharp mask; then noise and rounding.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "dsp/core/image_view.hpp"

namespace srd::fakes {

struct CornerPatch {
  double u = 20, v = 20;              // px, the corner
  double angle = 0.3;                 // rad, of the first edge's normal
  double skew = 0;                    // rad, off a right angle between the normals
  double blur = 0.9;                  // px, of the lens, >= 0; the pixel's area adds 1/12 to its square
  double mean = 128, contrast = 100;  // half sum and half difference of bright and dark, grey levels
  double noise = 0;                   // grey levels
  double square = 1e9;                // px to the next parallel edge
  int size = 41;                      // px
  double sharpening = 0;              // amount of an unsharp mask; its radius: standard deviation of its Gaussian, px
  double sharpening_radius = 1;
  bool noise_before_sharpening = false;  // as a sensor's is; else all of the noise is what the image's last step adds
};

namespace patch_detail {

// Gauss-Legendre of four points over a pixel; for edges sharper than that resolves, many points.
struct PixelSamples {
  std::vector<double> at, weight;
  explicit PixelSamples(double blur) {
    if (blur >= 0.2) {
      at = {-0.43056815579702629, -0.16999052179242813, 0.16999052179242813, 0.43056815579702629};
      weight = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
      return;
    }
    const int n = 20;
    for (int i = 0; i < n; ++i) {
      at.push_back((i + 0.5) / n - 0.5);
      weight.push_back(1.0 / n);
    }
  }
};

}  // namespace patch_detail

// Levels before sharpening and noise, 'size' + 2 'rim' pixels a side.
inline std::vector<double> render_levels(const CornerPatch& patch, int rim) {
  const double n1x = std::cos(patch.angle), n1y = std::sin(patch.angle);
  const double other = patch.angle + std::numbers::pi / 2 + patch.skew;
  const double n2x = std::cos(other), n2y = std::sin(other);
  const double rho = n1x * n2x + n1y * n2y;
  const double sigma = patch.blur;
  const double rest = sigma * std::sqrt(1 - rho * rho);
  const auto sign = [&](double at) { return (at > 0) != (std::abs(at) > patch.square) ? 1.0 : -1.0; };
  const auto wave = [&](double at, double width) {  // mean of the square wave over a normal distribution at 'at'
    if (width < 1e-3) return sign(at);
    double value = std::erf(at / (width * std::numbers::sqrt2));
    for (const double edge : {-patch.square, patch.square})
      value -= (edge > 0 ? 1 : -1) + std::erf((at - edge) / (width * std::numbers::sqrt2));
    return value;
  };
  // Where the wave is +1 or -1 over all of the lens's distribution but 2e-9, and over that of 'more' px around.
  const auto is_level = [&](double at, double more) {
    const double reach = 6 * sigma + more;
    return std::abs(at) > reach && std::abs(std::abs(at) - patch.square) > reach;
  };
  const auto level = [&](double u, double v) {
    const double across1 = n1x * (u - patch.u) + n1y * (v - patch.v);
    const double across2 = n2x * (u - patch.u) + n2y * (v - patch.v);
    // The edges are square to each other, or only one of them is near: a product.
    if (std::abs(rho) < 1e-9 || sigma < 1e-3 || is_level(across1, 0) || is_level(across2, 0))
      return wave(across1, sigma) * wave(across2, sigma);
    double sum = 0, weight = 0;
    // Two-point Gauss rule on pieces that end where the wave changes sign.
    double from = -5 * sigma;
    while (from < 5 * sigma) {
      double to = std::min(5 * sigma, from + sigma / 2);
      for (const double edge : {-patch.square - across1, -across1, patch.square - across1})
        if (edge > from && edge < to) to = edge;
      if (to - from < 1e-9) {
        from = to + 1e-9;
        continue;
      }
      for (const double g : {-0.5773502691896257, 0.5773502691896257}) {
        const double z = (from + to) / 2 + g * (to - from) / 2;
        const double w = (to - from) / 2 * std::exp(-z * z / (2 * sigma * sigma));
        sum += w * sign(across1 + z) * wave(across2 + rho * z, rest);
        weight += w;
      }
      from = to;
    }
    return sum / weight;
  };
  constexpr double kHalfPixel = std::numbers::sqrt2 / 2;  // from its middle to a corner
  const patch_detail::PixelSamples samples(patch.blur);
  const int side = patch.size + 2 * rim;
  std::vector<double> levels;
  levels.reserve(static_cast<std::size_t>(side * side));
  for (int row = -rim; row < patch.size + rim; ++row)
    for (int column = -rim; column < patch.size + rim; ++column) {
      const double across1 = n1x * (column - patch.u) + n1y * (row - patch.v);
      const double across2 = n2x * (column - patch.u) + n2y * (row - patch.v);
      if (is_level(across1, kHalfPixel) && is_level(across2, kHalfPixel)) {
        levels.push_back(patch.mean + patch.contrast * sign(across1) * sign(across2));
        continue;
      }
      double mean = 0;
      for (std::size_t j = 0; j < samples.at.size(); ++j)
        for (std::size_t i = 0; i < samples.at.size(); ++i)
          mean += samples.weight[i] * samples.weight[j] * level(column + samples.at[i], row + samples.at[j]);
      levels.push_back(patch.mean + patch.contrast * mean);
    }
  return levels;
}

// I + amount (I - G * I) with a sampled Gaussian; the rim goes.
inline std::vector<double> unsharp_mask(const std::vector<double>& levels, int side, int rim, double amount, double radius) {
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -rim; k <= rim; ++k) kernel.push_back(std::exp(-0.5 * k * k / (radius * radius)));
  for (const double k : kernel) sum += k;
  const int inner = side - 2 * rim;
  std::vector<double> rows(static_cast<std::size_t>(side * inner)), out;
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < inner; ++u) {
      double mean = 0;
      for (int k = -rim; k <= rim; ++k)
        mean += kernel[static_cast<std::size_t>(k + rim)] / sum * levels[static_cast<std::size_t>(v * side + u + rim + k)];
      rows[static_cast<std::size_t>(v * inner + u)] = mean;
    }
  for (int v = 0; v < inner; ++v)
    for (int u = 0; u < inner; ++u) {
      double mean = 0;
      for (int k = -rim; k <= rim; ++k)
        mean += kernel[static_cast<std::size_t>(k + rim)] / sum * rows[static_cast<std::size_t>((v + rim + k) * inner + u)];
      const double level = levels[static_cast<std::size_t>((v + rim) * side + u + rim)];
      out.push_back(level + amount * (level - mean));
    }
  return out;
}

inline std::vector<std::uint8_t> render(const CornerPatch& patch, std::mt19937& random) {
  const int rim = patch.sharpening > 0 ? static_cast<int>(std::ceil(3.5 * patch.sharpening_radius)) : 0;
  std::vector<double> levels = render_levels(patch, rim);
  std::normal_distribution<double> normal;
  const auto add_noise = [&] {
    if (patch.noise <= 0) return;
    for (double& level : levels) level += patch.noise * normal(random);
  };
  if (patch.noise_before_sharpening) add_noise();
  if (rim > 0) levels = unsharp_mask(levels, patch.size + 2 * rim, rim, patch.sharpening, patch.sharpening_radius);
  if (!patch.noise_before_sharpening) add_noise();
  std::vector<std::uint8_t> pixels;
  for (const double level : levels)
    pixels.push_back(static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, level)))));
  return pixels;
}

inline GrayView view(const std::vector<std::uint8_t>& pixels, int width) {
  return {pixels.data(), width, static_cast<int>(pixels.size()) / width, width};
}

}  // namespace srd::fakes
