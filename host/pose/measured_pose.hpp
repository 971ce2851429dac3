// SPDX-License-Identifier: Apache-2.0
// A camera's pose from reference images, with what is known of its errors and what they mean for the surface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/geometry/pose.hpp"
#include "dsp/pose/height_of_pose.hpp"
#include "host/pose/board_order.hpp"
#include "host/run/pose_estimation.hpp"

namespace srd::host {

// The flat surface of still water that a reference is seen through. No level: dry.
struct StillWater {
  std::optional<double> level_mm;  // above Z = 0, > plates
  double level_deviation_mm = 0;   // standard deviation of that
  dsp::Media<double> media;        // plates count in a dry tank too
  [[nodiscard]] bool wet() const { return level_mm.has_value(); }
  // What light crosses, null when nothing. Lives as long as this object is not changed.
  [[nodiscard]] const dsp::WaterAbove* above();

 private:
  dsp::WaterAbove above_;
};

struct PoseRequest {
  std::vector<std::filesystem::path> references;
  std::filesystem::path calibration;
  std::optional<std::filesystem::path> points_file;
  std::optional<PatternSize> board;
  std::optional<double> square_mm;
  OrderKnowledge order;
  StillWater water;
  CornerSearch search;
};

struct MeasuredPose {
  Calibration calibration;
  Points points;      // the pattern's list
  PatternSize board;  // rows of columns of that list
  double square_mm = 0;
  ReferenceView view;
  BoardOrder order;
  PoseFit fit;                                           // corners in the order of the view
  dsp::PoseMatrix covariance = dsp::PoseMatrix::Zero();  // of a dsp::PoseChange, the level's part included
  // Correlation of neighbouring corners' residuals, -1 to 1: near 0 for noise, near 1 where print or lens leave a pattern.
  double neighbour_correlation = 0;
  std::vector<std::string> warnings;

  // As pose.yml keeps them.
  [[nodiscard]] PoseErrors errors() const { return {covariance, fit.estimate.by_intrinsics, today()}; }
  [[nodiscard]] dsp::Vec3<double> point_of(std::size_t corner) const {
    return points[static_cast<std::size_t>(order.points[corner])];
  }
};

// The pattern that a request names: its points, rows and columns. kUsage and kInput: none or both given, a list that is not
// row by row, a size that differs.
struct NamedPattern {
  Points points;
  PatternSize board;
  double square_mm = 0;
};
[[nodiscard]] Outcome<NamedPattern> named_pattern(const PoseRequest& request);

// Problems of any of the files, see read_reference, order_of and fit_pose.
[[nodiscard]] Outcome<MeasuredPose> measure_pose(PoseRequest request);

// The same corners on other points of the pattern. Replaces points, fit, covariance, correlation and warnings.
[[nodiscard]] Outcome<void> fit_again(MeasuredPose& pose, const Points& points, StillWater& water, const std::string& where);

// Standard deviations: turns about the camera's axes (rad), translation (mm), centre in W (mm).
struct PoseDeviations {
  dsp::Vec3<double> turn, translation, centre;
};
[[nodiscard]] PoseDeviations deviations_of(const dsp::Pose<double>& pose, const dsp::PoseMatrix& covariance);

// What is left of a corner, where it lies on the pattern, mm along X and Y.
[[nodiscard]] std::vector<dsp::Vec2<double>> left_on_pattern(const MeasuredPose& pose, const dsp::WaterAbove* water);

}  // namespace srd::host
