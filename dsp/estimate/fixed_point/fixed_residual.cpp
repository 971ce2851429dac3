// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/fixed_point/fixed_residual.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {
namespace {

template <class To>
[[nodiscard]] bool store(double x, double limit, To& to) {
  if (!(std::abs(x) < limit)) return false;
  to = To::from_real(x);
  return true;
}

constexpr double kMaxLength = 1 << kFixedLengthBits, kMaxHeight = 1 << kFixedHeightBits;
constexpr double kMinWave = M_PI * (1 << -kFixedWaveBits);  // Lx, mm

}  // namespace

std::optional<FixedView> quantise(const View<double>& view) {
  FixedView out;
  const Vec3<double> centre = view.pose.centre();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (!store(centre[row], kMaxLength, out.centre[i])) return std::nullopt;
    for (std::size_t j = 0; j < 3; ++j)
      if (!store(view.pose.rotation(row, static_cast<Eigen::Index>(j)), 1.001, out.rotation[i][j])) return std::nullopt;
  }
  return out;
}

std::optional<FixedSurface> quantise(const SurfaceModel<double>& model, const Coefficients<double>& a) {
  FixedSurface out;
  out.modes = model.modes;
  if (a.size() != model.modes.size()) return std::nullopt;
  double sum = 0, bend = 0;
  for (int j = 0; j < model.modes.size(); ++j) {
    const Mode& mode = model.modes[j];
    sum += std::abs(a[j]);
    bend += std::abs(a[j]) * std::max(mode.m, mode.n);
    if (!store(a[j], kMaxHeight, out.coefficients[static_cast<std::size_t>(j)])) return std::nullopt;
  }
  if (!(sum < kMaxHeight) || !(bend < 1 << kFixedBendBits) || !(model.lx > kMinWave) || !(model.ly > kMinWave))
    return std::nullopt;
  const bool stored = store(model.lx, kMaxLength, out.lx) && store(model.ly, kMaxLength, out.ly) &&
                      store(model.x0, kMaxLength / 4, out.x0) && store(model.y0, kMaxLength / 4, out.y0);
  return stored ? std::optional(out) : std::nullopt;
}

std::optional<FixedMedia> quantise(const Media<double>& media) {
  FixedMedia out;
  if (media.n_layers < 0 || media.n_layers > kMaxLayers || !(media.air > 0) || !(media.water >= media.air)) return std::nullopt;
  // Indices against air, so that one number of bits holds them all.
  if (!store(media.air / media.water, 1.001, out.air_per_water) || !store(media.water / media.air, 3, out.water))
    return std::nullopt;
  out.n_layers = media.n_layers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(media.n_layers); ++i) {
    const Layer<double>& layer = media.layers[i];
    if (!(layer.thickness >= 0) || !(layer.index >= media.air)) return std::nullopt;
    if (!store(layer.thickness, kMaxHeight / 8, out.thickness[i]) || !store(layer.index / media.air, 3, out.index[i]))
      return std::nullopt;
  }
  return out;
}

std::optional<FixedPoint> quantise(const Vec3<double>& point) {
  FixedPoint out;
  for (std::size_t i = 0; i < 3; ++i)
    if (!store(point[static_cast<Eigen::Index>(i)], kMaxLength / 2, out[i])) return std::nullopt;
  return out;
}

std::optional<std::array<FixedRatio, 2>> quantise(const Vec2<double>& normalised) {
  std::array<FixedRatio, 2> out;
  for (std::size_t i = 0; i < 2; ++i)
    if (!store(normalised[static_cast<Eigen::Index>(i)], 1.2, out[i])) return std::nullopt;
  return out;
}

template class FixedResidual<std::int64_t>;

}  // namespace srd::dsp
