// SPDX-License-Identifier: Apache-2.0
// Taking frames in: which are fit to be fused, and when a moment is complete. moment.cpp fuses it.
#include "host/fusion/fusion.hpp"

#include <algorithm>

#include "drivers/support/formatted.hpp"
#include "host/coefficients/row_writer.hpp"

namespace srd::host {
namespace {

bool same_place(const dsp::SurfaceModel<double>& a, const dsp::SurfaceModel<double>& b) {
  return a.lx == b.lx && a.ly == b.ly && a.x0 == b.x0 && a.y0 == b.y0;
}

}  // namespace

const char* to_string(Unpaired cause) {
  switch (cause) {
    case Unpaired::kNoSurface: return "without a surface";
    case Unpaired::kNoWallTime: return "without a wall time";
    case Unpaired::kClockUnsure: return "clock too unsure";
    case Unpaired::kOtherSurface: return "another surface";
    case Unpaired::kNoMoment: return "between moments";
    case Unpaired::kLate: return "late";
    case Unpaired::kMoved: return "disagree with the others";
  }
  return "";
}

void Fusion::leave_out(const std::string& name, Board& board, Unpaired cause) {
  ++counts_[name].unpaired[static_cast<std::size_t>(cause)];
  if (board.told == cause || !options_.notify) return;
  std::string why;
  if (cause == Unpaired::kNoWallTime)
    why = "it does not know the wall time and its error: synchronise its clock (chrony, PTP), or state clock_sd_ms";
  else if (cause == Unpaired::kClockUnsure)
    why = formatted("its clock's standard deviation is %.3g ms, waves of these modes need %.3g ms", 1e3 * board.clock_sd_s,
                    1e3 * tolerance().clock_s);
  else if (cause == Unpaired::kOtherSurface)
    why = "its modes cannot be told apart over the area that it sees";
  else
    return;
  board.told = cause;
  options_.notify(options_.id + ": node " + name + " is left out: " + why);
}

void Fusion::take_model(Board& board, const proto::CoefficientFrame& frame) {
  board.model = frame.model.cast<double>();
  // A pattern of unknown size: over the surface's own lengths.
  board.area = {static_cast<double>(frame.centre_x_mm), static_cast<double>(frame.centre_y_mm),
                frame.pattern_x_mm > 0 ? static_cast<double>(frame.pattern_x_mm) : board.model.lx,
                frame.pattern_y_mm > 0 ? static_cast<double>(frame.pattern_y_mm) : board.model.ly};
  board.refractive_index = frame.refractive_index;
  board.map.reset();
}

Fusion::Board* Fusion::board_of(const proto::BootId& from, const proto::CoefficientFrame& frame) {
  const std::string name(from.node.view());
  const auto stated = options_.boards.find(name);
  if (name == options_.id || (!options_.boards.empty() && stated == options_.boards.end())) return nullptr;
  auto found = boards_.find(name);
  if (found == boards_.end()) {
    if (boards_.size() == kMaxBoards) return nullptr;
    found = boards_.emplace(name, Board{}).first;
    Board& board = found->second;
    board.bit = std::uint32_t{1} << (boards_.size() - 1);
    board.boot = from.boot;
    if (stated != options_.boards.end()) board.stated = stated->second;
    take_model(board, frame);
    counts_[name];
  } else if (found->second.boot != from.boot) {
    // A new start may have another pose, another model.
    Board& board = found->second;
    board.boot = from.boot;
    board.track.clear();
    watch_.forget(name);
    take_model(board, frame);
  }
  return &found->second;
}

TimeTolerance Fusion::tolerance() const {
  TimeTolerance least{1, 1};
  for (const auto& [name, board] : boards_) {
    const TimeTolerance own = tolerance_of(common_ ? *common_ : board.model, board.level_mm);
    least = {std::min(least.pair_s, own.pair_s), std::min(least.clock_s, own.clock_s)};
  }
  if (options_.pair_ms) least.pair_s = *options_.pair_ms * 1e-3;
  return least;
}

Outcome<void> Fusion::write(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  Board* board = board_of(from, frame);
  if (board == nullptr) return {};
  const std::string name(from.node.view());
  const auto left_out = [&](Unpaired cause) {
    leave_out(name, *board, cause);
    return Outcome<void>{};
  };
  auto surface = timed_surface(sequence, frame);
  if (!surface) return left_out(Unpaired::kNoSurface);
  board->level_mm = height_at_centre(frame) + board->stated.placement.z_mm;
  if (board->stated.clock_sd_ms) surface->clock_sd_s = *board->stated.clock_sd_ms * 1e-3;
  board->clock_sd_s = surface->clock_sd_s;
  if (surface->time_ns == 0 || surface->clock_sd_s <= 0) return left_out(Unpaired::kNoWallTime);
  if (surface->clock_sd_s > tolerance().clock_s) return left_out(Unpaired::kClockUnsure);
  const std::int64_t time_ns = surface->time_ns;
  if ((fused_ns_ != 0 && time_ns <= fused_ns_) || !board->track.add(std::move(*surface))) return left_out(Unpaired::kLate);
  if (first_ns_ == 0) first_ns_ = time_ns;
  newest_ns_ = std::max(newest_ns_, time_ns);
  return fuse_ready(false);
}

Outcome<void> Fusion::finish() {
  if (auto done = fuse_ready(true); !done) return done;
  for (auto& [name, board] : boards_) {
    counts_[name].unpaired[static_cast<std::size_t>(Unpaired::kNoMoment)] += board.track.unused();
    board.track.clear();
  }
  return {};
}

bool Fusion::is_heard(const Board& board) const {
  const auto& frames = board.track.frames();
  return !frames.empty() && newest_ns_ - frames.back().time_ns <= kPatience;
}

void Fusion::choose_common() {
  const Board* widest = nullptr;
  for (const auto& [name, board] : boards_) {
    // Cosines along a turned board's sides are none along the common ones.
    const auto rank = [](const Board& each) { return std::pair(each.stated.placement.turn_rad == 0, each.model.modes.size()); };
    if (widest == nullptr || rank(board) > rank(*widest)) widest = &board;
  }
  common_ = options_.model.value_or(widest->model);
  if (options_.model) return;
  const BoardPlacement& placement = widest->stated.placement;
  std::vector<dsp::Mode> modes(common_->modes.begin(), common_->modes.end());
  for (const auto& [name, board] : boards_)
    if (same_place(board.model, widest->model) && board.stated.placement == placement)
      for (const dsp::Mode& mode : board.model.modes)
        if (modes.size() < dsp::kMaxModes && std::find(modes.begin(), modes.end(), mode) == modes.end()) modes.push_back(mode);
  if (const auto list = dsp::ModeList::make(modes)) common_->modes = *list;
  const auto origin = placement.to_common({common_->x0, common_->y0});
  common_->x0 = origin.x();
  common_->y0 = origin.y();
}

void Fusion::choose_reference() {
  const auto now = boards_.find(reference_);
  if (now != boards_.end() && is_heard(now->second) && !watch_.has_moved(reference_)) return;
  double step = -1;
  for (const auto& [name, board] : boards_) {
    if (!is_heard(board) || watch_.has_moved(name) || board.track.usual_step_s() <= step) continue;
    reference_ = name;
    step = board.track.usual_step_s();
  }
}

bool Fusion::can_fuse(std::int64_t time_ns) const {
  if (newest_ns_ - time_ns > kPatience) return true;
  return std::all_of(boards_.begin(), boards_.end(), [&](const auto& each) {
    const auto& [name, board] = each;
    if (!is_heard(board)) return true;
    // The nearest frame may be the one after the moment, and its successor is wanted too.
    const double wanted_s = (name == reference_ ? 0.5 : 1.5) * board.track.usual_step_s();
    return static_cast<double>(board.track.frames().back().time_ns - time_ns) * 1e-9 >= wanted_s;
  });
}

Outcome<void> Fusion::fuse_ready(bool all) {
  if (first_ns_ == 0 || (!all && newest_ns_ - first_ns_ < kPatience)) return {};
  if (!common_) choose_common();
  for (;;) {
    choose_reference();
    const auto reference = boards_.find(reference_);
    if (reference == boards_.end()) return {};
    const auto& frames = reference->second.track.frames();
    const auto next =
        std::find_if(frames.begin(), frames.end(), [&](const TimedSurface& frame) { return frame.time_ns > fused_ns_; });
    if (next == frames.end()) return {};
    const std::int64_t time_ns = next->time_ns;
    if (!all && !can_fuse(time_ns)) return {};
    if (auto done = fuse_at(time_ns); !done) return done;
    fused_ns_ = time_ns;
    for (auto& [name, board] : boards_)
      counts_[name].unpaired[static_cast<std::size_t>(Unpaired::kNoMoment)] += board.track.forget_before(time_ns);
  }
}

std::vector<std::string> Fusion::summary() const {
  std::vector<std::string> lines{formatted("%s: %llu surfaces", options_.id.c_str(), static_cast<unsigned long long>(next_)) +
                                 (contradictory_ > 0
                                      ? formatted(", %llu of them inconsistent: two boards contradict each other",
                                                  static_cast<unsigned long long>(contradictory_))
                                      : "")};
  for (const auto& [name, counts] : counts_) {
    std::string line = "  " + name + formatted(": %llu frames used", static_cast<unsigned long long>(counts.used));
    for (std::size_t i = 0; i < kUnpairedCount; ++i)
      if (counts.unpaired[i] > 0)
        line += formatted(", %llu ", static_cast<unsigned long long>(counts.unpaired[i])) + to_string(static_cast<Unpaired>(i));
    lines.push_back(line);
  }
  return lines;
}

}  // namespace srd::host
