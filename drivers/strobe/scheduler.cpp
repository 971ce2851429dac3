// SPDX-License-Identifier: Apache-2.0
#include "drivers/strobe/scheduler.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <limits>

namespace srd {

namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

void raise(std::atomic<std::uint64_t>& counter, std::uint64_t more = 1) {
  counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
}
template <class T>
void set(std::atomic<T>& to, T value) {
  to.store(value, std::memory_order_relaxed);
}

// Room for a whole pattern's light at once, and a quarter pulse for edges that are not on time.
std::int64_t room_ns(const StrobeTiming& timing) { return timing.pulse_ns * timing.pattern.lit_count() + timing.pulse_ns / 4; }

}  // namespace

StrobeScheduler::StrobeScheduler(const StrobeTiming& timing, OutputLine* strobe, OutputLine* trigger, StrobeClock& clock)
    : timing_(timing),
      strobe_(strobe),
      trigger_(trigger),
      clock_(clock),
      duty_(timing.max_duty_ppm, room_ns(timing)),
      grid_(std::max<std::int64_t>(timing.trigger_rate_mhz, 1)),
      watch_(grid_.period_ns() / 2 - 1) {
  assert(strobe_ != nullptr || trigger_ != nullptr);
  assert((trigger_ != nullptr) == (timing.trigger_rate_mhz > 0));
  // The pulse and the lateness that it may have lie in the middle of the window.
  const std::int64_t window = timing.window_end_ns - timing.window_begin_ns;
  const std::int64_t used = timing.pulse_ns + timing.jitter_ns;
  on_offset_ns_ = timing.window_begin_ns + (window - used) / 2 - timing.delay_ns;
  // A prediction that is off by this much spends the spare window on one side and half the lateness.
  trust_ns_ = std::max<std::int64_t>(window - used, 0) / 2 + timing.jitter_ns / 2;
  all_off();
}

void StrobeScheduler::all_off() noexcept {
  if (strobe_ != nullptr) strobe_->set(false);
  if (trigger_ != nullptr) trigger_->set(false);
}

void StrobeScheduler::step() noexcept {
  take_stamps();
  const std::int64_t now = clock_.now_ns();
  if (trigger_ != nullptr)
    trigger(now);
  else
    follow(now);
}

void StrobeScheduler::take_stamps() noexcept {
  while (const StrobeStamp* stamp = stamps_.front()) {
    sensor_offset_ns_ = clock_.offset_ns(stamp->clock);
    const std::int64_t monotonic = stamp->time_ns - sensor_offset_ns_;
    if (trigger_ != nullptr)
      watch_.stamped(monotonic);
    else
      lock_.add(stamp->sequence, monotonic);
    stamps_.pop();
  }
}

void StrobeScheduler::publish(LockState state) noexcept {
  set(counters_.lock, state);
  set(counters_.rejected, lock_.counts().rejected);
  set(counters_.slips, lock_.counts().slips);
  set(counters_.locks, lock_.counts().locks);
  set(counters_.period_ns, lock_.period_ns());
  set(counters_.jitter_ns, lock_.jitter_ns());
  set(counters_.uncertainty_ns, lock_.uncertainty_ns(lock_.index() + 1));
}

void StrobeScheduler::follow(std::int64_t now_ns) noexcept {
  const LockState state = lock_.state(now_ns);
  publish(state);
  const bool locked = state == LockState::kLocked || state == LockState::kHoldover;
  if (!locked || (planned_ && generation_ != lock_.generation())) planned_ = false;
  if (locked && !planned_) {
    // Never two pulses for one exposure, also when a new line through the stamps counts them anew.
    const std::int64_t from = std::max(now_ns + kSettleNs, last_on_ns_ + lock_.period_ns() / 2);
    next_ = lock_.index_from(from - on_offset_ns_);
    generation_ = lock_.generation();
    planned_ = true;
    // Its pulse has no neighbour in the one before, which may be seconds old: a gap in the slots says so.
    if (slot_ > 0) ++slot_;
  }
  if (!planned_ || 3 * lock_.uncertainty_ns(next_) > trust_ns_) {
    planned_ = false;
    clock_.sleep_until(now_ns + kIdleNs);
    return;
  }

  StrobePulse pulse;
  const std::int64_t stamp = lock_.predict_ns(next_);
  const std::int64_t on = stamp + on_offset_ns_;
  pulse.slot = slot_;
  pulse.sequence = lock_.sequence_of(next_);
  pulse.stamp_ns = stamp + sensor_offset_ns_;
  if (!timing_.pattern.lit(slot_)) {
    pulse.phase = StrobePhase::kDark;
    raise(counters_.dark);
  } else if (now_ns > on + lock_.period_ns()) {  // stopped for longer than an exposure
    raise(counters_.skipped);
    raise(counters_.late);
  } else if (on - now_ns > kSettleNs) {
    clock_.sleep_until(std::min(on - kSettleNs, now_ns + kSliceNs));
    return;  // stamps that came meanwhile are used
  } else {
    flash(on, stamp + timing_.window_end_ns, kNever, pulse);
  }
  last_on_ns_ = on;
  emit(pulse);
  ++next_;
  ++slot_;
}

void StrobeScheduler::trigger(std::int64_t now_ns) noexcept {
  set(counters_.triggers_missed, watch_.missed());
  set(counters_.untriggered, watch_.untriggered());
  const std::int64_t period = grid_.period_ns();
  const std::int64_t offset = clock_.offset_ns(ClockId::kRealtime);
  if (wall_known_ && std::abs(offset - wall_offset_ns_) > kStepNs) {
    raise(counters_.wall_steps);
    planned_ = false;
  }
  wall_offset_ns_ = offset;
  wall_known_ = true;
  if (!planned_) {
    next_ = grid_.first_from(std::max(now_ns, last_on_ns_ + period - period / 4) + offset);
    planned_ = true;
  }
  const std::int64_t at = grid_.time_ns(next_) - offset;
  if (at - now_ns > kSettleNs) {
    clock_.sleep_until(std::min(at - kSettleNs, now_ns + kSliceNs));
    return;
  }
  clock_.sleep_until(at);
  const std::int64_t now = clock_.now_ns();
  lateness_.add(now - at);
  if (now - at > timing_.jitter_ns) raise(counters_.late);
  if (now - at > period / 2) {  // nearer to the next moment: other boards have left this one
    raise(counters_.skipped);
    planned_ = false;
    return;
  }
  trigger_->set(true);
  raise(counters_.triggers);
  last_on_ns_ = at;
  const std::int64_t stamp = now + timing_.stamp_after_trigger_ns;
  watch_.triggered(stamp);
  StrobePulse pulse;
  pulse.slot = slot_++;
  pulse.stamp_ns = stamp + sensor_offset_ns_;
  ++next_;
  const bool lit = strobe_ != nullptr && timing_.pattern.lit(pulse.slot);
  if (strobe_ != nullptr && !lit) {
    pulse.phase = StrobePhase::kDark;
    raise(counters_.dark);
  }
  flash(lit ? stamp + on_offset_ns_ : kNever, stamp + timing_.window_end_ns, now + timing_.trigger_pulse_ns, pulse);
  emit(pulse);
}

void StrobeScheduler::flash(std::int64_t on_ns, std::int64_t light_end_ns, std::int64_t trigger_off_ns,
                            StrobePulse& pulse) noexcept {
  std::int64_t off_ns = kNever, began_ns = 0;
  while (on_ns != kNever || off_ns != kNever || trigger_off_ns != kNever) {
    clock_.sleep_until(std::min({on_ns, off_ns, trigger_off_ns}));
    const std::int64_t now = clock_.now_ns();
    // However late it is: what is on goes off before anything else is done.
    if (off_ns <= now) {
      strobe_->set(false);
      const std::int64_t ended = clock_.now_ns();
      off_ns = kNever;
      const std::int64_t lasted = ended - began_ns;
      duty_.add(ended, lasted);
      if (lasted > timing_.max_pulse_ns) raise(counters_.overlong);
      if (ended + timing_.delay_ns > light_end_ns) raise(counters_.spilled);
      if (lasted > counters_.longest_ns.load(std::memory_order_relaxed)) set(counters_.longest_ns, lasted);
      pulse.off_ns = now + (ended - now) / 2 + timing_.delay_ns + sensor_offset_ns_;
    }
    if (trigger_off_ns <= now) {
      trigger_->set(false);
      trigger_off_ns = kNever;
    }
    if (on_ns <= now) {
      const std::int64_t late = now - on_ns;
      if (trigger_ == nullptr) lateness_.add(late);
      if (late > timing_.jitter_ns) raise(counters_.late);
      const std::int64_t light_begin = on_ns + timing_.delay_ns + sensor_offset_ns_;
      on_ns = kNever;
      if (now + timing_.delay_ns + timing_.pulse_ns > light_end_ns) {
        raise(counters_.skipped);
      } else if (!duty_.allows(now, timing_.pulse_ns)) {
        raise(counters_.withheld);
      } else {
        strobe_->set(true);
        const std::int64_t switched = clock_.now_ns();
        began_ns = now;
        off_ns = now + timing_.pulse_ns;
        pulse.phase = StrobePhase::kLit;
        pulse.planned_on_ns = light_begin;
        pulse.planned_off_ns = light_begin + timing_.pulse_ns;
        pulse.on_ns = now + (switched - now) / 2 + timing_.delay_ns + sensor_offset_ns_;
        raise(counters_.pulses);
      }
    }
  }
}

void StrobeScheduler::emit(const StrobePulse& pulse) noexcept {
  if (!pulses_.try_push(pulse)) raise(counters_.unread);
}

}  // namespace srd
