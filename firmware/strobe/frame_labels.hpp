// SPDX-License-Identifier: Apache-2.0
// Which light made a frame: from the strobe's pulses, checked against how bright the image is. No heap, no lock, no
// floating point; one thread, but for the counters.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "drivers/camera/camera.hpp"
#include "drivers/strobe/strobe_pulse.hpp"

namespace srd::firmware {

// Written by the labelling thread, read by any.
struct LabelCounters {
  std::atomic<std::uint64_t> lit{0}, dark{0};
  std::atomic<std::uint64_t> unlit{0};           // should have been lit, and was not: its pulse was skipped
  std::atomic<std::uint64_t> unlabelled{0};      // no pulse: the strobe was not locked, or the pulse is another frame's
  std::atomic<std::uint64_t> mislabelled{0};     // the image says otherwise; it is believed
  std::atomic<std::uint64_t> resyncs{0};         // another shift between frames and pulses was found to agree
  std::atomic<int> lit_level{0}, dark_level{0};  // running, 1/16 grey level; 0: not known
};

class FrameLabels {
 public:
  static constexpr int kWindow = 32;        // frames that levels and shifts are judged by
  static constexpr int kMinFrames = 8;      // of them before anything is said
  static constexpr int kWrongToResync = 3;  // disagreements in the window

  // dark_difference: grey levels between lit and dark that confirm labels. region: of the image; empty: all of it.
  FrameLabels(const StrobePattern& pattern, int dark_difference, const Region& region)
      : pattern_(pattern), difference_q4_(16 * dark_difference), region_(region) {}

  // Ascending slots.
  void add(const StrobePulse& pulse) noexcept;
  // frame.time_ns as the camera gave it: it is matched to the pulses' predicted stamps.
  void label(CameraFrame& frame) noexcept;
  [[nodiscard]] const LabelCounters& counters() const { return counters_; }
  // Pulses later than a frame's own whose light it shows.
  [[nodiscard]] int shift() const { return shift_; }

 private:
  static constexpr std::int64_t kPulses = 256;  // kept; more than frames can be under way

  struct Seen {
    std::int64_t slot = 0;
    int mean_q4 = 0;
  };
  struct Levels {
    int lit_q4 = 0, dark_q4 = 0;
    bool apart = false;
    [[nodiscard]] bool lit(int mean_q4) const { return 2 * mean_q4 > lit_q4 + dark_q4; }
  };
  [[nodiscard]] const StrobePulse* at(std::int64_t slot) const;
  [[nodiscard]] const StrobePulse* nearest(std::int64_t stamp_ns) const;
  [[nodiscard]] Levels levels() const;
  // Frames of the window that disagree with the pulses so far on; known: frames that have one.
  [[nodiscard]] int disagreements(int shift, const Levels& levels, int& known) const;
  void resync(const Levels& levels, std::int64_t slot) noexcept;

  StrobePattern pattern_;
  int difference_q4_;
  Region region_;
  std::array<StrobePulse, kPulses> pulses_{};
  std::int64_t newest_ = -1;  // slot; -1: none
  std::int64_t oldest_ = 0;
  std::int64_t last_slot_ = -1;  // that lit a frame; -1: none
  std::array<Seen, kWindow> seen_{};
  int seen_count_ = 0, seen_next_ = 0;
  int shift_ = 0;
  LabelCounters counters_;
};

}  // namespace srd::firmware
