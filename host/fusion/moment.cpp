// SPDX-License-Identifier: Apache-2.0
// One moment: each board's surface brought to it, tested against the others, added, and given on as a frame.
#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/fusion/fusion.hpp"
#include "proto/information.hpp"

namespace srd::host {
namespace {

// Frames further apart than so many of a board's usual steps are no neighbours.
constexpr double kSteps = 2.5;

// rms over the area of the surface with these coefficients, mm.
double rms_height(const dsp::SurfaceModel<double>& model, const BoardArea& area, const Eigen::VectorXd& a) {
  constexpr int kSide = 9;
  const dsp::Coefficients<double> coefficients = a;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = area.x_mm + area.width_mm * ((i % kSide + 0.5) / kSide - 0.5);
    const double y = area.y_mm + area.height_mm * ((i / kSide + 0.5) / kSide - 0.5);
    const double z = model.height(coefficients, x, y);
    sum += z * z;
  }
  return std::sqrt(sum / (kSide * kSide));
}

}  // namespace

void Fusion::tell(const BoardWatch::Event& event) const {
  if (!options_.notify) return;
  const std::string node = options_.id + ": node " + event.name;
  if (!event.moved) {
    options_.notify(node + " agrees with the others again");
    return;
  }
  const Board& board = boards_.at(event.name);
  const double height = rms_height(board.model, board.area, event.shift_mm);
  options_.notify(node + (event.one_of_two ? " and the other have" : " has") +
                  formatted(" shifted against %s by %.3g mm rms (%.0f standard deviations): ",
                            event.one_of_two ? "each other" : "the others", height, event.significance) +
                  (event.one_of_two
                       ? "a camera or a pattern has moved, and two boards cannot say whose; surfaces are inconsistent"
                       : "its camera or pattern has moved; it is left out") +
                  " (srd-node --doctor, srd rig-check)");
}

std::vector<Part> Fusion::parts_at(std::int64_t time_ns) {
  const double pair_s = tolerance().pair_s;
  std::vector<Part> parts;
  for (auto& [name, board] : boards_) {
    Part part;
    auto surface = board.track.at(time_ns, pair_s, kSteps * board.track.usual_step_s());
    if (!surface) continue;
    if (!board.map) {
      auto map = map_to_board(*common_, board.model, board.stated.placement, board.area);
      if (!map) {
        leave_out(name, board, Unpaired::kOtherSurface);
        continue;
      }
      board.map = std::move(*map);
    }
    auto contribution = contribution_of(*surface, *board.map, last_);
    if (!contribution) continue;
    part.name = name;
    part.bit = board.bit;
    part.surface = std::move(*surface);
    part.map = &*board.map;
    part.contribution = std::move(*contribution);
    parts.push_back(std::move(part));
  }
  return parts;
}

Outcome<void> Fusion::fuse_at(std::int64_t time_ns) {
  std::vector<Part> parts = parts_at(time_ns);
  const bool consistent = watch_.look(time_ns, parts, common_->modes.size());
  for (const BoardWatch::Event& event : watch_.take_events()) tell(event);
  for (const Part& part : parts) {
    boards_.at(part.name).track.mark_used(time_ns);
    if (watch_.has_moved(part.name))
      ++counts_[part.name].unpaired[static_cast<std::size_t>(Unpaired::kMoved)];
    else
      ++counts_[part.name].used;
  }
  std::erase_if(parts, [&](const Part& part) { return watch_.has_moved(part.name); });
  if (parts.empty()) return {};
  return emit(time_ns, parts, consistent);
}

Outcome<void> Fusion::emit(std::int64_t time_ns, const std::vector<Part>& parts, bool consistent) {
  proto::CoefficientFrame frame;
  frame.model = common_->cast<float>();
  frame.stamp = {time_ns, ClockId::kRealtime, time_ns, 0};
  double weight = 0, square = 0, clock = 0;
  double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;
  std::vector<const Contribution*> contributions;
  for (const Part& part : parts) {
    const Board& board = boards_.at(part.name);
    contributions.push_back(&part.contribution);
    frame.corners_expected += part.surface.corners_expected;
    frame.corners_found += part.surface.corners_found;
    frame.corners_used += part.surface.corners_used;
    weight += part.surface.corners_used;
    square += part.surface.corners_used * part.surface.reprojection_rms_px * part.surface.reprojection_rms_px;
    clock += 1 / (part.surface.clock_sd_s * part.surface.clock_sd_s);
    frame.refractive_index = board.refractive_index;
    for (const double side_x : {-0.5, 0.5})
      for (const double side_y : {-0.5, 0.5}) {
        const auto corner = board.stated.placement.to_common(
            {board.area.x_mm + side_x * board.area.width_mm, board.area.y_mm + side_y * board.area.height_mm});
        low_x = std::min(low_x, corner.x());
        high_x = std::max(high_x, corner.x());
        low_y = std::min(low_y, corner.y());
        high_y = std::max(high_y, corner.y());
      }
  }
  frame.centre_x_mm = static_cast<float>((low_x + high_x) / 2);
  frame.centre_y_mm = static_cast<float>((low_y + high_y) / 2);
  frame.pattern_x_mm = static_cast<float>(high_x - low_x);
  frame.pattern_y_mm = static_cast<float>(high_y - low_y);
  frame.stamp.wall_uncertainty_ns = static_cast<std::uint64_t>(1e9 / std::sqrt(clock));
  frame.reprojection_rms_px = weight > 0 ? static_cast<float>(std::sqrt(square / weight)) : 0;
  frame.mean_error = frame.reprojection_rms_px;
  frame.source_sequence = next_;
  const auto fused = add_information(contributions, common_->modes.size());
  if (!fused) {
    frame.status = proto::FrameStatus::kTooFewCorners;
    frame.stop = dsp::Stop::kSingular;
  } else {
    frame.status = consistent ? proto::FrameStatus::kOk : proto::FrameStatus::kInconsistent;
    frame.stop = dsp::Stop::kGradient;
    contradictory_ += consistent ? 0 : 1;
    last_ = fused->coefficients;
    frame.coefficients = fused->coefficients.cast<float>();
    const dsp::InformationMatrix<double> information = fused->information;
    (void)proto::quantise(information, frame.information);
  }
  const proto::BootId from{*proto::NodeId::make(options_.id), options_.boot};
  for (FrameSink* sink : options_.sinks)
    if (auto done = sink->write(from, next_, frame); !done) return done;
  ++next_;
  return {};
}

}  // namespace srd::host
