// SPDX-License-Identifier: Apache-2.0
// What a camera at its place can tell of the surface, before it has taken a picture.
#pragma once

#include <span>
#include <string>

#include "dsp/estimate/estimator/estimator.hpp"
#include "firmware/config/node_config.hpp"

namespace srd::firmware {

// Sees the points through the configured guess and fits them as a frame would. A line for each thing that a person
// should know before the run: points outside the image or region, coefficients that the view cannot separate. Empty: all
// is well. width, height: of the image, px.
[[nodiscard]] std::string check_view(const NodeConfig& config, const dsp::View<double>& view,
                                     const dsp::SurfaceModel<double>& model, const dsp::Media<double>& media,
                                     std::span<const dsp::Vec3<double>> points, int width, int height);

}  // namespace srd::firmware
