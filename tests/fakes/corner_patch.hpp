// SPDX-License-Identifier: Apache-2.0
// A checkerboard corner as a camera sees it: the mean of a two-dimensional square wave over the lens's normal distribution (exact
// for straight edges: integrated along one normal with the error function along the other), averaged over each pixel's area;
// then, where the camera sharpens, an unsharp mask; then noise and rounding.
#pragma once

#include <algorithm>
#include <array>
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

// Gauss-Legendre of four points over a pixel; sharp edges want it over parts of the pixel, of two deviations at most.
struct PixelSamples {
  std::vector<double> at, weight;
  explicit PixelSamples(double blur) {
    constexpr double kAt[]{-0.43056815579702629, -0.16999052179242813, 0.16999052179242813, 0.43056815579702629};
    constexpr double kWeight[]{0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
    const int parts = blur >= 0.2 ? 1 : static_cast<int>(std::ceil(0.5 / blur));
    for (int part = 0; part < parts; ++part)
      for (int i = 0; i < 4; ++i) {
        at.push_back((part + 0.5 + kAt[i]) / parts - 0.5);
        weight.push_back(kWeight[i] / parts);
      }
  }
};

// A pixel's mean of the product of two edges' signs, each edge at n.x = 0 from the pixel's centre as at + nx x + ny y: exact. Along
// each row of the pixel the mean is linear between the rows where an edge leaves the pixel or the edges meet.
struct SharpEdge {
  double nx, ny, at;
};

inline double mean_of_signs(const SharpEdge& a, const SharpEdge& b) {
  const auto sign = [](double x) { return x > 0 ? 1.0 : -1.0; };
  std::array<double, 7> rows{-0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5};  // what is not needed stays an empty piece at the end
  std::size_t count = 2;
  const auto ends_at = [&](double numerator, double denominator) {
    if (std::abs(numerator) < 0.5 * std::abs(denominator)) rows[count++] = numerator / denominator;
  };
  for (const SharpEdge& edge : {a, b})
    for (const double x : {-0.5, 0.5}) ends_at(-edge.at - edge.nx * x, edge.ny);
  ends_at(b.nx * a.at - a.nx * b.at, a.nx * b.ny - b.nx * a.ny);
  std::sort(rows.begin(), rows.end());
  double mean = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double y = (rows[i - 1] + rows[i]) / 2;
    std::array<double, 4> ends{-0.5, 0.5, 0.5, 0.5};
    std::size_t pieces = 2;
    for (const SharpEdge& edge : {a, b}) {
      const double at = -edge.at - edge.ny * y;
      if (std::abs(at) < 0.5 * std::abs(edge.nx)) ends[pieces++] = at / edge.nx;
    }
    std::sort(ends.begin(), ends.end());
    double row = 0;
    for (std::size_t k = 1; k < ends.size(); ++k) {
      const double x = (ends[k - 1] + ends[k]) / 2;
      row += (ends[k] - ends[k - 1]) * sign(a.at + a.nx * x + a.ny * y) * sign(b.at + b.nx * x + b.ny * y);
    }
    mean += (rows[i] - rows[i - 1]) * row;
  }
  return mean;
}

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
  const bool is_sharp = sigma < 1e-3;
  const patch_detail::PixelSamples samples(is_sharp ? 1 : sigma);
  const double reach = 0.75 + 7 * sigma;  // px, how far from its centre a pixel is touched by an edge
  const auto pixel = [&](double u, double v) {
    const double across1 = n1x * (u - patch.u) + n1y * (v - patch.v);
    const double across2 = n2x * (u - patch.u) + n2y * (v - patch.v);
    // Of the parallel edges the nearest one counts, with its sign.
    const auto nearest = [&](double at) { return std::abs(at) > patch.square / 2 ? patch.square - std::abs(at) : at; };
    const double near1 = nearest(across1), near2 = nearest(across2);
    if (std::abs(near1) > reach && std::abs(near2) > reach) return sign(across1) * sign(across2);
    if (is_sharp) {
      const auto turn = [&](double at) { return std::abs(at) > patch.square / 2 && at > 0 ? -1.0 : 1.0; };
      return patch_detail::mean_of_signs({turn(across1) * n1x, turn(across1) * n1y, near1},
                                         {turn(across2) * n2x, turn(across2) * n2y, near2});
    }
    double mean = 0;
    for (std::size_t j = 0; j < samples.at.size(); ++j)
      for (std::size_t i = 0; i < samples.at.size(); ++i)
        mean += samples.weight[i] * samples.weight[j] * level(u + samples.at[i], v + samples.at[j]);
    return mean;
  };
  const int side = patch.size + 2 * rim;
  std::vector<double> levels;
  levels.reserve(static_cast<std::size_t>(side * side));
  for (int row = -rim; row < patch.size + rim; ++row)
    for (int column = -rim; column < patch.size + rim; ++column)
      levels.push_back(patch.mean + patch.contrast * pixel(column, row));
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
