// SPDX-License-Identifier: Apache-2.0
// Pictures of a calibration.
#pragma once

#include "drivers/recording/image_file.hpp"
#include "host/calibrate/calibration.hpp"
#include "host/plot/figures.hpp"

namespace srd::host {

// One image with its corners: those used, those left out, and residuals enlarged.
[[nodiscard]] Figure corners_figure(const CalibrationResult& result, std::size_t view, const GrayImage& image);
// Residuals of all views where they lie in the image.
[[nodiscard]] Figure residual_figure(const CalibrationResult& result);
// Deviation of a projected point over the image, and where corners were seen.
[[nodiscard]] Figure uncertainty_figure(const CalibrationResult& result);
// Rms of each view, and how much it adds.
[[nodiscard]] Figure views_figure(const CalibrationResult& result);

// The image as the lens without distortion and the same camera matrix would have taken it; black where nothing was seen.
[[nodiscard]] GrayImage undistorted(const GrayImage& image, const bundle::CameraFit& fit);

}  // namespace srd::host
