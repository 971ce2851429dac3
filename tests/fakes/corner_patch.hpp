// A checkerboard corner as a blurred camera sees it, exact for straight edges: the mean of a two-dimensional square wave
// over a normal distribution, integrated along one normal with the error function along the other.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "dsp/core/image_view.hpp"

namespace srd::fakes {

struct CornerPatch {
  double u = 20, v = 20;        // px, the corner
  double angle = 0.3;           // rad, of the first edge's normal
  double skew = 0;              // rad, off a right angle between the normals
  double blur = 0.9;            // px, of the lens; the pixel's area adds 1/12
  double mean = 128, contrast = 100;  // half sum and half difference of bright and dark, grey levels
  double noise = 0;             // grey levels
  double square = 1e9;          // px to the next parallel edge
  int size = 41;                // px
};

inline std::vector<std::uint8_t> render(const CornerPatch& patch, std::mt19937& random) {
  const double n1x = std::cos(patch.angle), n1y = std::sin(patch.angle);
  const double other = patch.angle + std::numbers::pi / 2 + patch.skew;
  const double n2x = std::cos(other), n2y = std::sin(other);
  const double rho = n1x * n2x + n1y * n2y;
  const double sigma = std::sqrt(patch.blur * patch.blur + 1.0 / 12);
  const double rest = sigma * std::sqrt(1 - rho * rho);
  const auto wave = [&](double at, double width) {  // mean of the square wave over a normal distribution at 'at'
    double value = std::erf(at / (width * std::numbers::sqrt2));
    for (const double edge : {-patch.square, patch.square})
      value -= (edge > 0 ? 1 : -1) + std::erf((at - edge) / (width * std::numbers::sqrt2));
    return value;
  };
  const auto sign = [&](double at) { return (at > 0) != (std::abs(at) > patch.square) ? 1.0 : -1.0; };
  std::normal_distribution<double> normal;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(patch.size * patch.size));
  for (int row = 0; row < patch.size; ++row)
    for (int column = 0; column < patch.size; ++column) {
      const double across1 = n1x * (column - patch.u) + n1y * (row - patch.v);
      const double across2 = n2x * (column - patch.u) + n2y * (row - patch.v);
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
      const double level = patch.mean + patch.contrast * sum / weight + (patch.noise > 0 ? patch.noise * normal(random) : 0);
      pixels[static_cast<std::size_t>(row * patch.size + column)] =
          static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, level))));
    }
  return pixels;
}

inline GrayView view(const std::vector<std::uint8_t>& pixels, int width) {
  return {pixels.data(), width, static_cast<int>(pixels.size()) / width, width};
}

}  // namespace srd::fakes
