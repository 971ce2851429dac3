// SPDX-License-Identifier: Apache-2.0
#include "host/plot/spectrum.hpp"

#include <cmath>

#include <opencv2/core.hpp>

namespace srd::host {
namespace {

constexpr std::size_t kMinSteps = 8, kMaxSteps = std::size_t{1} << 24U;

// The series on even steps.
std::vector<double> resampled(std::span<const double> seconds, std::span<const double> values, double interval_s,
                              std::size_t steps, double& filled_fraction) {
  std::vector<std::size_t> valid;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) valid.push_back(i);
  std::vector<double> even;
  if (valid.empty()) return even;
  std::size_t at = 0, filled = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    const double t = seconds.front() + static_cast<double>(k) * interval_s;
    while (at + 1 < valid.size() && std::abs(seconds[valid[at + 1]] - t) <= std::abs(seconds[valid[at]] - t)) ++at;
    if (std::abs(seconds[valid[at]] - t) > 0.5 * interval_s * (1 + 1e-6)) ++filled;
    even.push_back(values[valid[at]]);
  }
  filled_fraction = static_cast<double>(filled) / static_cast<double>(steps);
  return even;
}

}  // namespace

Spectrum amplitude_spectrum(std::span<const double> seconds, std::span<const double> values, double interval_s) {
  Spectrum spectrum;
  if (seconds.size() < 2 || !(interval_s > 0)) return spectrum;
  const double length = std::round((seconds.back() - seconds.front()) / interval_s) + 1;
  if (!(length >= static_cast<double>(kMinSteps)) || length > static_cast<double>(kMaxSteps)) return spectrum;
  const auto n = static_cast<std::size_t>(length);
  std::vector<double> even = resampled(seconds, values, interval_s, n, spectrum.filled_fraction);
  if (even.empty()) return spectrum;

  std::size_t padded = 1;
  while (padded < 4 * n) padded *= 2;
  // The mean under the window, so that what is left has no line at 0 Hz at all.
  std::vector<double> window(n);
  double window_sum = 0, weighted = 0;
  for (std::size_t i = 0; i < n; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * M_PI * static_cast<double>(i) / length);
    window_sum += window[i];
    weighted += window[i] * even[i];
  }
  cv::Mat series = cv::Mat::zeros(1, static_cast<int>(padded), CV_64F);
  for (std::size_t i = 0; i < n; ++i) series.at<double>(static_cast<int>(i)) = window[i] * (even[i] - weighted / window_sum);
  cv::Mat transformed;
  cv::dft(series, transformed, cv::DFT_COMPLEX_OUTPUT);
  const double step_hz = 1 / (static_cast<double>(padded) * interval_s);
  for (std::size_t k = 1; k <= padded / 2; ++k) {
    const auto& line = transformed.at<cv::Vec2d>(static_cast<int>(k));
    spectrum.frequency_hz.push_back(static_cast<double>(k) * step_hz);
    // At half the sample rate both sides fall together.
    const double sides = k == padded / 2 ? 1 : 2;
    spectrum.amplitude.push_back(sides * std::hypot(line[0], line[1]) / window_sum);
  }
  spectrum.resolution_hz = 2 / (length * interval_s);
  return spectrum;
}

}  // namespace srd::host
