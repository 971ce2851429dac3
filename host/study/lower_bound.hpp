// SPDX-License-Identifier: Apache-2.0
// What no unbiased estimate beats. Optics (19), (20).
#pragma once

#include <span>

#include "dsp/estimate/solver/information.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace srd::study {

// A tank as its cameras see it.
struct Tank {
  std::span<const dsp::View<double>> views;
  std::span<const dsp::Vec3<double>> points;  // F, mm, W
  dsp::SurfaceModel<double> model;
  dsp::Media<double> media;
};

// sum J_i' J_i / sigma^2 at the surface a over the corners that one view sees, 1/mm^2; (19). sigma_px: of a corner, per
// axis. seen: indices of points; empty: all. kOutOfDomain or kNotConverged when a corner cannot be seen.
[[nodiscard]] Result<dsp::InformationMatrix<double>> information_bound(const Tank& tank, std::size_t view,
                                                                       const dsp::Coefficients<double>& a, double sigma_px,
                                                                       std::span<const int> seen = {});

// Least rms error of the surface over the points, mm, for coefficients with this information. kSingular.
[[nodiscard]] Result<double> surface_bound(const Tank& tank, const dsp::InformationMatrix<double>& information);

// rms over the points of the difference of two surfaces, mm.
[[nodiscard]] double surface_error(const Tank& tank, const dsp::Coefficients<double>& a,
                                   const dsp::Coefficients<double>& truth);

// Least standard deviation of a corner per axis, px: contrast (bright - dark) and noise in grey levels, blur (sigma of
// the lens; the pixel's area is added here) and half window in px; (20).
[[nodiscard]] double corner_bound(double contrast, double blur_px, double noise, int half_window);

}  // namespace srd::study
