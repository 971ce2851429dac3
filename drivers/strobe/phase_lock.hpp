// SPDX-License-Identifier: Apache-2.0
// An integer phase-locked loop on a sensor's time stamps: predicts when the next frames are stamped. No floating point,
// no clock, no heap. One thread per object.
//
// Start: a line through kWindow stamps, by medians, so that one or two bad stamps do no harm. Then the recursion
//     e = stamp - prediction;  phase = prediction + a e;  period += b e / frames since the last stamp
// first with the gains of a least-squares line through n stamps, a = 2(2n-1)/(n(n+1)), b = 6/(n(n+1)), until they fall to
// the steady ones, a = 1/8, b = 1/256. Those are just over critical damping (b = 2 - a - 2 sqrt(1-a) would be 1/240): no
// overshoot after a step of the rate. Natural frequency sqrt(b) / (2 pi) = 1/100 of the frame rate, slow against stamp
// jitter, fast against a crystal's drift. White jitter s leaves 0.29 s in the next frame's prediction (see spread_q20).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "dsp/core/integer_math.hpp"

namespace srd {

enum class LockState : std::uint8_t {
  kUnlocked,   // no stamps, or none for too long
  kAcquiring,  // stamps come, and no line fits them well enough yet
  kLocked,
  kHoldover,  // locked, and the last stamps are missing: predictions go on, their uncertainty grows
};

[[nodiscard]] constexpr const char* to_string(LockState state) {
  switch (state) {
    case LockState::kUnlocked: return "unlocked";
    case LockState::kAcquiring: return "acquiring";
    case LockState::kLocked: return "locked";
    case LockState::kHoldover: return "holdover";
  }
  return "unlocked";
}

struct PhaseLockCounts {
  std::uint64_t accepted = 0;
  std::uint64_t rejected = 0;  // stamps far from their prediction, not used
  std::uint64_t slips = 0;     // frames that were lost without a gap in the sequence numbers
  std::uint64_t locks = 0;     // lines fitted: 1 after a start, more after steps of the rate
};

class PhaseLock {
 public:
  static constexpr int kWindow = 8;                 // stamps of the first line
  static constexpr int kMinInliers = 6;             // of them on the line
  static constexpr int kLockFrames = 10;            // stamps in the recursion before it counts as locked
  static constexpr int kSteadyFrames = 31;          // where the least-squares gains reach the steady ones
  static constexpr int kMaxRejected = 4;            // in a row: the rate has changed
  static constexpr int kMaxSlips = 2;               // in a row; more: the rate has fallen to a part
  static constexpr std::int64_t kMaxMissed = 4096;  // frames that holdover lasts
  static constexpr std::int64_t kMinPeriodNs = 100'000, kMaxPeriodNs = 10'000'000'000;
  // Stamps closer than this to their prediction are never outliers: interrupt latency of an idle kernel.
  static constexpr std::int64_t kGateFloorNs = 20'000;
  // How much a period may wander while nothing is seen: a crystal's temperature drift over seconds, with room.
  static constexpr std::int64_t kWanderPerMillion = 1;

  // One frame's stamp. Sequence numbers grow by one a frame; a gap means frames without a stamp.
  void add(std::uint64_t sequence, std::int64_t stamp_ns) {
    if (tracking_ && sequence > last_sequence_ && stamp_ns > phase_ns_)
      track(sequence, stamp_ns);
    else
      restart(sequence, stamp_ns);
  }
  void reset() { *this = PhaseLock(); }

  // now_ns: of the stamps' clock.
  [[nodiscard]] LockState state(std::int64_t now_ns) const {
    if (!tracking_) {
      const bool stale = filled_ == 0 || now_ns - window_[static_cast<std::size_t>(filled_ - 1)].ns > kMaxPeriodNs;
      return stale ? LockState::kUnlocked : LockState::kAcquiring;
    }
    const std::int64_t missed = (now_ns - phase_ns_) / (period_q16_ >> 16);
    if (missed > kMaxMissed) return LockState::kUnlocked;
    if (frames_ < kLockFrames || rejected_in_a_row_ >= kMaxRejected) return LockState::kAcquiring;
    // A frame may be read out and handed over for a whole period before its stamp is here.
    return missed > 2 ? LockState::kHoldover : LockState::kLocked;
  }

  // Exposures have indices that grow by one; they start anew with every line fitted (generation()).
  [[nodiscard]] std::uint64_t generation() const { return counts_.locks; }
  [[nodiscard]] std::int64_t index() const { return index_; }  // of the last stamp
  // Within kMaxMissed of index().
  [[nodiscard]] std::int64_t predict_ns(std::int64_t index) const {
    return phase_ns_ + shift_rounded((index - index_) * period_q16_ + fraction_q16_, 16);
  }
  [[nodiscard]] std::uint64_t sequence_of(std::int64_t index) const {
    return last_sequence_ + static_cast<std::uint64_t>(index - index_);
  }
  // The first exposure stamped at or after a time.
  [[nodiscard]] std::int64_t index_from(std::int64_t time_ns) const {
    const std::int64_t apart = std::clamp((time_ns - phase_ns_) / (period_q16_ >> 16), -kMaxMissed, kMaxMissed);
    std::int64_t index = index_ + apart - 1;
    while (predict_ns(index) < time_ns && index < index_ + kMaxMissed) ++index;
    return index;
  }
  [[nodiscard]] std::int64_t period_ns() const { return shift_rounded(period_q16_, 16); }
  // One standard deviation of a stamp about its prediction, as seen lately.
  [[nodiscard]] std::int64_t jitter_ns() const { return jitter_ns_q8_ >> 8; }
  // One standard deviation of predict_ns: the jitter that the loop lets through, and the period's wander since.
  // kMaxPeriodNs without a line.
  [[nodiscard]] std::int64_t uncertainty_ns(std::int64_t index) const {
    if (!tracking_) return kMaxPeriodNs;
    const std::int64_t ahead = std::clamp<std::int64_t>(index - index_, 0, kMaxMissed);
    const std::int64_t root_q20 = dsp::isqrt(static_cast<std::uint64_t>(spread_q20(ahead)) << 20);
    return ((jitter_ns() * root_q20) >> 20) + ahead * period_ns() / 1'000'000 * kWanderPerMillion;
  }
  [[nodiscard]] const PhaseLockCounts& counts() const { return counts_; }

 private:
  struct Stamp {
    std::uint64_t sequence = 0;
    std::int64_t ns = 0;
  };
  template <std::size_t N>
  [[nodiscard]] static std::int64_t median(std::array<std::int64_t, N> values) {
    std::sort(values.begin(), values.end());
    return values[N / 2 - 1] + (values[N / 2] - values[N / 2 - 1]) / 2;
  }
  [[nodiscard]] static std::int64_t shift_rounded(std::int64_t x, int shift) {
    return (x + (std::int64_t{1} << (shift - 1))) >> shift;
  }

  // Variance of the prediction that many frames ahead of the last stamp, over the stamps' own, Q20. With gains a, b:
  // (2a^2 + b(2-3a) + 2k b(2a-b) + 2k^2 b^2) / (a(4-2a-b)); of a line through n stamps: 1/n + 3(2k+n-1)^2 / (n(n^2-1)).
  [[nodiscard]] std::int64_t spread_q20(std::int64_t k) const {
    if (frames_ >= kSteadyFrames) {
      constexpr std::int64_t kA = 32, kB = 1;  // in 1/256
      return ((2 * kA * kA + kB * (512 - 3 * kA) + 2 * k * kB * (2 * kA - kB) + 2 * k * k * kB * kB) << 20) /
             (kA * (1024 - 2 * kA - kB));
    }
    const std::int64_t n = frames_;
    return (std::int64_t{1} << 20) / n + ((3 * (2 * k + n - 1) * (2 * k + n - 1)) << 20) / (n * (n * n - 1));
  }

  void restart(std::uint64_t sequence, std::int64_t stamp_ns) {
    tracking_ = false;
    collect(sequence, stamp_ns);
  }

  void collect(std::uint64_t sequence, std::int64_t stamp_ns) {
    if (filled_ > 0) {
      const Stamp& last = window_[static_cast<std::size_t>(filled_ - 1)];
      const bool follows = sequence > last.sequence && stamp_ns > last.ns;
      if (!follows || stamp_ns - last.ns > 4 * kMaxPeriodNs || sequence - last.sequence > 64) filled_ = 0;
    }
    if (filled_ == kWindow) {
      std::copy(window_.begin() + 1, window_.end(), window_.begin());
      --filled_;
    }
    window_[static_cast<std::size_t>(filled_++)] = {sequence, stamp_ns};
    if (filled_ == kWindow && fit()) filled_ = 0;
  }

  // A line through the window, robust to bad stamps; then the recursion over those on it.
  [[nodiscard]] bool fit() {
    constexpr std::size_t kHalf = kWindow / 2;
    std::array<std::int64_t, kHalf> slopes{};
    for (std::size_t i = 0; i < kHalf; ++i)
      slopes[i] = ((window_[i + kHalf].ns - window_[i].ns) << 16) /
                  static_cast<std::int64_t>(window_[i + kHalf].sequence - window_[i].sequence);
    const std::int64_t period_q16 = median(slopes);
    if (period_q16 >> 16 < kMinPeriodNs || period_q16 >> 16 > kMaxPeriodNs) return false;
    std::array<std::int64_t, kWindow> residual{}, away{};
    for (std::size_t i = 0; i < kWindow; ++i)
      residual[i] = window_[i].ns - window_[0].ns -
                    ((static_cast<std::int64_t>(window_[i].sequence - window_[0].sequence) * period_q16) >> 16);
    const std::int64_t middle = median(residual);
    for (std::size_t i = 0; i < kWindow; ++i) away[i] = std::abs(residual[i] - middle);
    const std::int64_t scatter = median(away);
    const std::int64_t gate = std::min(std::max(kGateFloorNs, 6 * scatter), period_q16 >> 19);
    if (std::count_if(away.begin(), away.end(), [&](std::int64_t a) { return a <= gate; }) < kMinInliers) return false;

    frames_ = 0;
    rejected_in_a_row_ = slips_in_a_row_ = 0;
    period_q16_ = period_q16;
    jitter_ns_q8_ = std::max<std::int64_t>(scatter * 3 / 2, kMinJitterNs) << 8;
    ++counts_.locks;
    for (std::size_t i = 0; i < kWindow; ++i) {
      if (away[i] > gate) {
        ++counts_.rejected;
      } else if (frames_ == 0) {
        phase_ns_ = window_[i].ns;
        fraction_q16_ = 0;
        index_ = 0;
        last_sequence_ = window_[i].sequence;
        frames_ = 1;
        ++counts_.accepted;
      } else {
        correct(static_cast<std::int64_t>(window_[i].sequence - last_sequence_), window_[i]);
      }
    }
    tracking_ = true;
    return true;
  }

  void track(std::uint64_t sequence, std::int64_t stamp_ns) {
    const std::int64_t period = period_ns();
    const std::uint64_t gap = sequence - last_sequence_;
    if (gap > static_cast<std::uint64_t>(kMaxMissed) || (stamp_ns - phase_ns_) / period > kMaxMissed) {
      filled_ = 0;
      restart(sequence, stamp_ns);
      return;
    }
    std::int64_t frames = static_cast<std::int64_t>(gap);
    std::int64_t error = stamp_ns - predict_ns(index_ + frames);
    const std::int64_t gate = std::min(6 * (jitter_ns() + uncertainty_ns(index_ + frames)) + kGateFloorNs, period / 4);
    // Frames that were lost and not numbered: off by whole periods, not yet seen as a change of the rate.
    const std::int64_t slip = (error + period / 2) / period;
    if (std::abs(error) <= gate) {
      slips_in_a_row_ = 0;
    } else if (slip > 0 && frames + slip <= kMaxMissed && rejected_in_a_row_ == 0 && slips_in_a_row_ < kMaxSlips &&
               std::abs(error - slip * period) <= gate) {
      ++slips_in_a_row_;
      counts_.slips += static_cast<std::uint64_t>(slip);
      frames += slip;
      error -= slip * period;
    }
    if (std::abs(error) > gate) {
      ++counts_.rejected;
      ++rejected_in_a_row_;
      collect(sequence, stamp_ns);  // to start from if these are right
      return;
    }
    rejected_in_a_row_ = 0;
    filled_ = 0;
    // After a long silence the phase has to be found again quickly.
    if (frames > kWindow) frames_ = std::min(frames_, kWindow);
    correct(frames, {sequence, stamp_ns});
  }

  // |e| <= period / 4 < 2^32 ns: its Q16 times 2(2n-1) <= 122 stays below 2^55. frames * period: below 2^12 2^50.
  void correct(std::int64_t frames, const Stamp& stamp) {
    const std::int64_t ahead_q16 = frames * period_q16_ + fraction_q16_;
    const std::int64_t error_q16 = ((stamp.ns - phase_ns_) << 16) - ahead_q16;
    const std::int64_t n = ++frames_;
    std::int64_t phase_q16 = ahead_q16;
    if (n < kSteadyFrames) {
      phase_q16 += error_q16 * (2 * (2 * n - 1)) / (n * (n + 1));
      period_q16_ += error_q16 * 6 / (n * (n + 1)) / frames;
    } else {
      frames_ = kSteadyFrames;
      phase_q16 += error_q16 / 8;
      period_q16_ += error_q16 / 256 / frames;
    }
    period_q16_ = std::clamp(period_q16_, kMinPeriodNs << 16, kMaxPeriodNs << 16);
    phase_ns_ += phase_q16 >> 16;
    fraction_q16_ = phase_q16 & 0xffff;
    index_ += frames;
    last_sequence_ = stamp.sequence;
    if (n > 2) {  // two stamps lie on their line
      // Mean |e| of a normal distribution is 4/5 of its standard deviation.
      const std::int64_t seen_q8 = (std::abs(error_q16) >> 8) * 5 / 4;
      jitter_ns_q8_ = std::max(jitter_ns_q8_ + (seen_q8 - jitter_ns_q8_) / 32, kMinJitterNs << 8);
    }
    ++counts_.accepted;
  }

  static constexpr std::int64_t kMinJitterNs = 100;  // of any clock's reading

  std::array<Stamp, kWindow> window_{};
  int filled_ = 0;
  bool tracking_ = false;
  std::int64_t phase_ns_ = 0;      // smoothed stamp of index_, with its fraction
  std::int64_t fraction_q16_ = 0;  // 0..65535
  std::int64_t period_q16_ = 1 << 16;
  std::int64_t index_ = 0;
  std::uint64_t last_sequence_ = 0;
  int frames_ = 0;  // that the gains count
  int rejected_in_a_row_ = 0, slips_in_a_row_ = 0;
  std::int64_t jitter_ns_q8_ = 0;
  PhaseLockCounts counts_;
};

}  // namespace srd
