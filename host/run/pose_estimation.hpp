// SPDX-License-Identifier: Apache-2.0
// Pose of a camera from an image of the dry pattern whose points are known. Optics (1)-(3); guide 3.2 and appendix A.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "dsp/core/image_view.hpp"
#include "dsp/pose/pose_fit.hpp"
#include "host/run/board_corners.hpp"

namespace srd::host {

struct PoseFit {
  dsp::Pose<double> pose;
  double rms_px = 0;    // of the residuals, per axis
  double worst_px = 0;  // largest residual
  int corners = 0;
  dsp::PoseEstimate estimate;              // the same pose with its errors
  double common_px = 0;                    // added to every corner's deviation: print, lens; 0: these explain what is left
  std::vector<dsp::Vec2<double>> left_px;  // of each corner: found minus seen from the pose
  std::vector<std::string> warnings;
};

// As pose.yml keeps them; of a dry reference, today's.
[[nodiscard]] inline PoseErrors errors_of(const PoseFit& fit) {
  return {fit.estimate.covariance(), fit.estimate.by_intrinsics, today()};
}

// The board's own points, row by row: X = row * square_mm, Y = column * square_mm, Z = 0.
[[nodiscard]] Points board_points(PatternSize board, double square_mm);
// Points in the order in which the camera sees them: positions 2 and 3 see the list from its end.
[[nodiscard]] Points seen_order(const Points& points, int position);

// corners[i] shows points[i]; what is longer is cut.
[[nodiscard]] std::vector<dsp::PoseCorner> with_points(std::span<const BoardCorner> corners,
                                                       std::span<const dsp::Vec3<double>> points);
// where: for messages. water: what the corners are seen through; null: dry, without plates. kInput: fewer than 4 points,
// points in one line, a corner outside the field of the calibration, residuals above 5 px rms, or a camera below the pattern
// (mirrored order).
[[nodiscard]] Outcome<PoseFit> fit_pose(const Calibration& calibration, std::span<const dsp::PoseCorner> corners,
                                        const std::string& where, const dsp::WaterAbove* water = nullptr);
// The same where all corners count alike: pixels[i] (raw) shows points[i].
[[nodiscard]] Outcome<PoseFit> fit_pose(const Calibration& calibration, std::span<const dsp::Vec2<double>> pixels,
                                        std::span<const dsp::Vec3<double>> points, const std::string& where);

// points: as seen, top left first, along u. sample_bits: as read_gray_image takes it. Warns when the square at W's origin is bright and a half turn explains it.
[[nodiscard]] Outcome<PoseFit> pose_from_image(const std::filesystem::path& image, const Calibration& calibration,
                                               const Points& points, PatternSize board, const CornerSearch& search,
                                               int sample_bits = 0);

// Whether the square between W's (0,0) and (square, square) is bright, from one corner and its point. square: mm.
[[nodiscard]] bool first_square_bright(const BoardCorner& corner, const dsp::Vec3<double>& point, double square,
                                       const dsp::View<double>& view);

// kInput when the image has not the size the calibration was made at.
[[nodiscard]] Outcome<void> check_size(const GrayView& image, const Calibration& calibration,
                                       const std::filesystem::path& file);

}  // namespace srd::host
