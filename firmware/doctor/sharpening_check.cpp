// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/sharpening_check.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/support/formatted.hpp"
#include "dsp/frontend/board_finder.hpp"

namespace srd::firmware {

namespace {

constexpr int kMaxCorners = 4096;
constexpr double kQ12 = 4096;
constexpr double kSharpest = 0.05;  // px, so that the formula holds

// The mean of a step of deviation s over a pixel whose middle is d px behind it.
double step(double d, double s) {
  const auto whole = [&](double x) {
    return x * 0.5 * std::erfc(-x / (s * std::sqrt(2.0))) + s * std::exp(-0.5 * x * x / (s * s)) / std::sqrt(2 * M_PI);
  };
  return whole(d + 0.5) - whole(d - 0.5);
}

const char* control_of(const std::string& kind) {
  if (kind == "v4l2")
    return "camera.sharpness at the least (leave it out), 'v4l2-ctl -L' for controls of other names (sharpness, edge "
           "enhancement, denoise), the camera's own menu; or a raw format (camera.format)";
  if (kind == "libcamera")
    return "camera.sharpness = 0 (leave it out); where it is and edges still overshoot, rpi.sharpen in the camera's tuning "
           "file, or a monochrome sensor, whose raw stream is taken";
  if (kind == "simulator") return "image.sharpen_amount = 0 in the scene";
  return "recordings made with the camera's sharpening off";
}

}  // namespace

double overshoot(const dsp::Sharpening& sharpening, double blur_px) {
  const double amount = sharpening.amount_q12 / kQ12, radius = sharpening.radius_q12 / kQ12;
  const double s = std::max(blur_px, kSharpest), soft = std::hypot(s, radius);
  double most = 0;
  for (double d = 0; d < 4 * soft; d += 0.05) {
    const double sharp = step(d, s);
    most = std::max(most, sharp + amount * (sharp - step(d, soft)) - 1);
  }
  return most;
}

void check_sharpening(const GrayView& image, const dsp::DetectorOptions& options, dsp::BoardSize board, const std::string& kind,
                      Diagnosis& diagnosis) {
  dsp::BoardFinder finder(image.width, image.height, kMaxCorners);
  const auto grid = finder.find(image, options, board);
  if (!grid) return;
  std::vector<double> blurs;
  for (const int cell : grid->cells)
    if (cell >= 0) blurs.push_back(finder.corners()[static_cast<std::size_t>(cell)].shape.blur_q12 / kQ12);
  if (blurs.empty()) return;
  const auto middle = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2);
  std::nth_element(blurs.begin(), middle, blurs.end());
  const dsp::Sharpening& found = finder.sharpening();
  if (found.amount_q12 == 0) {
    diagnosis.ok("sharpening", formatted("none: edges of %.2f px blur do not overshoot", *middle));
    return;
  }
  diagnosis.warn(
      "sharpening",
      formatted("unsharp mask of amount %.2f, radius %.2f px: edges of %.2f px blur overshoot by %.0f %% of their height",
                found.amount_q12 / kQ12, found.radius_q12 / kQ12, *middle, 100 * overshoot(found, *middle)),
      control_of(kind));
}

}  // namespace srd::firmware
