// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/frame_labels.hpp"

#include <algorithm>
#include <cstdlib>

#include "firmware/strobe/brightness.hpp"

namespace srd::firmware {

namespace {

void raise(std::atomic<std::uint64_t>& counter) {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

void FrameLabels::add(const StrobePulse& pulse) noexcept {
  // A gap in the slots: pulses were lost on the way, and what is older does not connect.
  if (newest_ < 0 || pulse.slot != newest_ + 1) oldest_ = pulse.slot;
  newest_ = pulse.slot;
  oldest_ = std::max(oldest_, newest_ - kPulses + 1);
  pulses_[static_cast<std::size_t>(pulse.slot % kPulses)] = pulse;
}

const StrobePulse* FrameLabels::at(std::int64_t slot) const {
  if (newest_ < 0 || slot < oldest_ || slot > newest_) return nullptr;
  return &pulses_[static_cast<std::size_t>(slot % kPulses)];
}

const StrobePulse* FrameLabels::nearest(std::int64_t stamp_ns) const {
  // Frames come soon after their pulses: from the newest one back.
  std::int64_t slot = newest_;
  while (at(slot) != nullptr && at(slot)->stamp_ns > stamp_ns) --slot;
  const StrobePulse *before = at(slot), *after = at(slot + 1);
  if (before == nullptr && after == nullptr) return nullptr;
  const bool later = before == nullptr || (after != nullptr && after->stamp_ns - stamp_ns < stamp_ns - before->stamp_ns);
  const StrobePulse* found = later ? after : before;
  // An exposure's own pulse is less than half an exposure away.
  const StrobePulse* beside = at(found->slot - 1) != nullptr ? at(found->slot - 1) : at(found->slot + 1);
  if (beside == nullptr) return nullptr;
  const std::int64_t period = std::abs(beside->stamp_ns - found->stamp_ns);
  return std::abs(found->stamp_ns - stamp_ns) * 2 < period ? found : nullptr;
}

FrameLabels::Levels FrameLabels::levels() const {
  Levels levels;
  if (seen_count_ < kMinFrames) return levels;
  levels.lit_q4 = levels.dark_q4 = seen_[0].mean_q4;
  for (int i = 0; i < seen_count_; ++i) {
    levels.lit_q4 = std::max(levels.lit_q4, seen_[static_cast<std::size_t>(i)].mean_q4);
    levels.dark_q4 = std::min(levels.dark_q4, seen_[static_cast<std::size_t>(i)].mean_q4);
  }
  // From the extremes to the means of the two groups.
  std::int64_t sum[2] = {0, 0};
  int count[2] = {0, 0};
  for (int i = 0; i < seen_count_; ++i) {
    const int mean = seen_[static_cast<std::size_t>(i)].mean_q4;
    const int group = levels.lit(mean) ? 1 : 0;
    sum[group] += mean;
    ++count[group];
  }
  if (count[0] == 0 || count[1] == 0) return levels;
  levels.dark_q4 = static_cast<int>(sum[0] / count[0]);
  levels.lit_q4 = static_cast<int>(sum[1] / count[1]);
  levels.apart = levels.lit_q4 - levels.dark_q4 >= difference_q4_;
  return levels;
}

int FrameLabels::disagreements(int shift, const Levels& levels, int& known) const {
  int wrong = 0;
  known = 0;
  for (int i = 0; i < seen_count_; ++i) {
    const Seen& seen = seen_[static_cast<std::size_t>(i)];
    const StrobePulse* pulse = at(seen.slot + shift);
    if (pulse == nullptr) continue;
    ++known;
    if ((pulse->phase == StrobePhase::kLit) != levels.lit(seen.mean_q4)) ++wrong;
  }
  return wrong;
}

// Of all shifts within a pattern the nearest one that agrees with every frame, and whose pulse has been already.
void FrameLabels::resync(const Levels& levels, std::int64_t slot) noexcept {
  int known = 0;
  if (disagreements(shift_, levels, known) < kWrongToResync) return;
  for (int distance = 0; distance < pattern_.length; ++distance)
    for (const int shift : {-distance, distance}) {
      if (at(slot + shift) == nullptr || disagreements(shift, levels, known) > 0 ||
          known < std::max(kMinFrames, 2 * pattern_.length - 1))
        continue;
      shift_ = shift;
      raise(counters_.resyncs);
      return;
    }
}

void FrameLabels::label(CameraFrame& frame) noexcept {
  frame.strobe = StrobePhase::kUnstrobed;
  const StrobePulse* own = nearest(frame.time_ns);
  // A stamp that is far off may be nearest to the exposure of the frame before: a pulse lights one frame.
  if (own == nullptr || own->slot <= last_slot_) {
    raise(counters_.unlabelled);
    return;
  }
  last_slot_ = own->slot;
  const int mean = mean_brightness_q4(frame.image, region_);
  seen_[static_cast<std::size_t>(seen_next_)] = {own->slot, mean};
  seen_next_ = (seen_next_ + 1) % kWindow;
  seen_count_ = std::min(seen_count_ + 1, kWindow);
  const Levels levels = this->levels();

  const StrobePulse* pulse = shift_ == 0 ? own : at(own->slot + shift_);
  bool lit = pulse != nullptr && pulse->phase == StrobePhase::kLit;
  // Only a pattern with both says what an image should look like.
  if (levels.apart && pattern_.has_dark()) {
    counters_.lit_level.store(levels.lit_q4, std::memory_order_relaxed);
    counters_.dark_level.store(levels.dark_q4, std::memory_order_relaxed);
    const bool bright = levels.lit(mean);
    if (bright != lit) {
      raise(counters_.mislabelled);
      resync(levels, own->slot);
      pulse = at(own->slot + shift_);
      lit = bright;
    }
  }
  if (lit) {
    frame.strobe = StrobePhase::kLit;
    if (pulse != nullptr && pulse->phase == StrobePhase::kLit) frame.time_ns = pulse->middle_ns();
    raise(counters_.lit);
    if (!pattern_.has_dark()) {
      const int level = counters_.lit_level.load(std::memory_order_relaxed);
      counters_.lit_level.store(level == 0 ? mean : level + (mean - level) / 8, std::memory_order_relaxed);
    }
    return;
  }
  const bool on_purpose = pulse != nullptr && pulse->phase == StrobePhase::kDark;
  raise(on_purpose || pulse == nullptr ? counters_.dark : counters_.unlit);
  // A pulse that was left out by necessity may still have left light enough.
  const int level = counters_.lit_level.load(std::memory_order_relaxed);
  if (on_purpose || (level > 0 && mean + difference_q4_ <= level)) frame.strobe = StrobePhase::kDark;
}

}  // namespace srd::firmware
