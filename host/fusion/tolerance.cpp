// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/tolerance.hpp"

#include <algorithm>
#include <cmath>

namespace srd::host {
namespace {

constexpr double kGravity = 9.81;          // m/s^2
constexpr double kTensionPerRho = 7.3e-5;  // m^3/s^2, clean water at 20 degrees C

}  // namespace

double fastest_wave(const dsp::SurfaceModel<double>& model, double depth_mm) {
  double highest = 0;  // k^2, 1/m^2
  for (const dsp::Mode& mode : model.modes) {
    // A slope is what is left of half a wave in a view that is shorter.
    const double m = mode.kind == dsp::Mode::Kind::kSlopeX ? 1 : mode.m;
    const double n = mode.kind == dsp::Mode::Kind::kSlopeY ? 1 : mode.n;
    const double kx = m * M_PI / (model.lx * 1e-3), ky = n * M_PI / (model.ly * 1e-3);
    highest = std::max(highest, kx * kx + ky * ky);
  }
  const double k = std::sqrt(highest);
  const double depth = std::max(depth_mm, 0.0) * 1e-3;
  return std::sqrt((kGravity * k + kTensionPerRho * k * k * k) * std::tanh(k * depth));
}

TimeTolerance tolerance_of(const dsp::SurfaceModel<double>& model, double depth_mm) {
  const double omega = std::max(fastest_wave(model, depth_mm), 1e-3);
  return {std::min(kPairPhase / omega, 0.05), std::min(kClockPhase / omega, 0.02)};
}

}  // namespace srd::host
