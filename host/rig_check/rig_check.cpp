// SPDX-License-Identifier: Apache-2.0
#include "host/rig_check/rig_check.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"

namespace srd::host {

namespace {

constexpr double kDegrees = 180 / M_PI;
constexpr double kRestlessVariance = 9;

std::string three(const char* format, const dsp::Vec3<double>& v) {
  return formatted(format, v.x()) + " " + formatted(format, v.y()) + " " + formatted(format, v.z());
}

std::string toml_list(const dsp::Vec3<double>& v) {
  return "[" + formatted("%.9g", v.x()) + ", " + formatted("%.9g", v.y()) + ", " + formatted("%.9g", v.z()) + "]";
}

}  // namespace

Outcome<RigComparison> check_rig(RigRequest request) {
  const auto reference = measure_pose(request.reference);
  if (!reference) return reference.error();
  PoseRequest later_request = request.reference;
  later_request.references = request.later;
  later_request.water = request.later_water;
  const auto later = measure_pose(later_request);
  if (!later) return later.error();

  std::vector<const BoardCorner*> after(reference->points.size());
  for (std::size_t i = 0; i < later->view.corners.size(); ++i)
    after[static_cast<std::size_t>(later->order.points[i])] = &later->view.corners[i];
  std::vector<dsp::CornerPair> pairs;
  for (std::size_t i = 0; i < reference->view.corners.size(); ++i) {
    const BoardCorner& then = reference->view.corners[i];
    const BoardCorner& now = *after[static_cast<std::size_t>(reference->order.points[i])];
    pairs.push_back({reference->point_of(i), then.pixel, now.pixel, then.sigma_px, now.sigma_px});
  }
  const auto deviation = [](const StillWater& water) { return water.wet() ? water.level_deviation_mm : 0.0; };
  std::vector<dsp::PoseCorner> workspace(pairs.size());
  const auto poses = dsp::compare_poses(reference->calibration.camera, reference->fit.pose, pairs,
                                        {request.reference.water.above(), deviation(request.reference.water)},
                                        {request.later_water.above(), deviation(request.later_water)}, workspace);
  if (!poses)
    return Problem{Exit::kInput,
                   "cannot be compared with the reference",
                   request.later.front().string(),
                   "corners that agree with a pose",
                   to_string(poses.error()),
                   ""};

  RigComparison out;
  out.poses = *poses;
  out.corners = static_cast<int>(pairs.size());
  out.significant = poses->by_chance < request.false_alarm;
  out.moved = out.significant && poses->largest_move_px >= request.least_px;
  const dsp::Vec3<double> turn = poses->change.head<3>();
  out.turn_deg = turn.norm() * kDegrees;
  out.turn_axis = turn.norm() > 0 ? dsp::Vec3<double>(turn.normalized()) : dsp::Vec3<double>::UnitZ();
  const dsp::Mat3<double> turns = poses->covariance.topLeftCorner<3, 3>();
  out.turn_deviation_deg = std::sqrt(out.turn_axis.dot(turns * out.turn_axis)) * kDegrees;
  out.shift = poses->after.centre() - poses->before.centre();
  out.shift_deviation = deviations_of(poses->after, poses->covariance).centre;
  // A square's side in the image, where it is largest, turns pixels into mm.
  const double side_px = (reference->view.corners[1].pixel - reference->view.corners[0].pixel).norm();
  out.largest_move_mm = poses->largest_move_px / side_px * reference->square_mm;
  out.warnings = reference->warnings;
  out.warnings.insert(out.warnings.end(), later->warnings.begin(), later->warnings.end());
  if (poses->variance_factor > kRestlessVariance)
    out.warnings.push_back(
        formatted("apart from the move, corners differ %.1f times more than their deviations say: ",
                  std::sqrt(poses->variance_factor)) +
        "water that is not still, a level or an index that is not the one given, other focus, or a print that has bent");
  return out;
}

std::string rig_text(const RigComparison& found, const RigRequest& request) {
  const dsp::PoseComparison& poses = found.poses;
  std::string text;
  if (found.moved) {
    text = "moved: camera and pattern are no longer as they were against each other\n";
  } else if (found.significant) {
    text =
        formatted("unmoved: no corner shifts by %g px or more, though what little there is is no chance\n", request.least_px);
  } else {
    text = "unmoved: what differs is noise\n";
  }
  text += formatted("  turn %.5f +- %.5f degrees about ", found.turn_deg, found.turn_deviation_deg) +
          three("%.3f", found.turn_axis) + " of the camera\n";
  text += "  shift of the camera against the pattern " + three("%.4f", found.shift) + " +- " +
          three("%.4f", found.shift_deviation) + " mm\n";
  text += formatted("  largest move of a corner %.4f px, %.4f mm on the pattern; %d corners\n", poses.largest_move_px,
                    found.largest_move_mm, found.corners);
  text += formatted("  F %.3f of 6 and %d degrees of freedom; an unmoved rig shows as much with a probability of %.2g; ",
                    poses.statistic, 2 * found.corners - 6, poses.by_chance) +
          formatted("told below %g\n", request.false_alarm);
  return text;
}

std::string rig_toml(const RigComparison& found, const RigRequest& request) {
  const dsp::PoseComparison& poses = found.poses;
  std::string text = "# Lengths mm, angles degrees unless a key says otherwise; deviations are one standard deviation.\n";
  text += std::string("moved = ") + (found.moved ? "true" : "false") +
          "\nsignificant = " + (found.significant ? "true" : "false") + "\n";
  text += formatted("corners = %d\nturn_deg = %.9g\nturn_deviation_deg = %.9g\n", found.corners, found.turn_deg,
                    found.turn_deviation_deg);
  text += "turn_axis_in_camera = " + toml_list(found.turn_axis) + "\nshift_mm = " + toml_list(found.shift) +
          "\nshift_deviation_mm = " + toml_list(found.shift_deviation) + "\n";
  text += formatted("largest_move_px = %.9g\nlargest_move_mm = %.9g\nstatistic = %.9g\nby_chance = %.9g\n",
                    poses.largest_move_px, found.largest_move_mm, poses.statistic, poses.by_chance);
  text += formatted("variance_factor = %.6g\nfalse_alarm = %g\nleast_px = %g\n", poses.variance_factor, request.false_alarm,
                    request.least_px);
  return text;
}

}  // namespace srd::host
