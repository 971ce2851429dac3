// SPDX-License-Identifier: Apache-2.0
// The strobe of a running node: its lines, its thread, the labels that it gives to frames.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "firmware/loop/frame_light.hpp"
#include "firmware/strobe/frame_labels.hpp"
#include "firmware/strobe/strobe_section.hpp"

namespace srd::firmware {

// How the run was, for a person.
struct StrobeReport {
  StrobeMode mode = StrobeMode::kOff;
  LockState lock = LockState::kUnlocked;
  double rate_hz = 0, jitter_us = 0, uncertainty_us = 0;  // as the lock sees the camera
  std::uint64_t locks = 0, rejected = 0, slips = 0;
  std::uint64_t pulses = 0, dark = 0, late = 0, skipped = 0, withheld = 0, overlong = 0, spilled = 0, faults = 0;
  double longest_us = 0;
  std::uint64_t triggers = 0, triggers_missed = 0, untriggered = 0, wall_steps = 0;
  std::uint64_t lit_frames = 0, dark_frames = 0, unlit = 0, unlabelled = 0, mislabelled = 0, resyncs = 0;
  std::uint64_t early = 0;  // frames that came before the middle of their exposure: their stamps mark something else
  int shift = 0;
  double lit_level = 0, dark_level = 0;  // grey levels; 0: not known
  std::string lateness;
  // One line a subject; empty when there is no strobe.
  [[nodiscard]] std::string text() const;
};

class Strobe final : public FrameLight {
 public:
  // Lines opened, low; nothing runs yet. enter: what the strobe's thread does first (its priority). region: of the image that
  // brightness is judged by. kDevice for lines that are not there, kUsage for a build that has none.
  [[nodiscard]] static Outcome<std::unique_ptr<Strobe>> open(const StrobeSection& section, const FrameTiming& frame,
                                                             double frame_rate_hz, const Region& region);
  // With lines and a clock of one's own; trigger: only in trigger mode, strobe may be null then.
  Strobe(const StrobeSection& section, const StrobeTiming& timing, const Region& region, std::unique_ptr<OutputLine> strobe,
         std::unique_ptr<OutputLine> trigger, std::unique_ptr<StrobeClock> clock);
  ~Strobe() override { stop(); }

  void start(std::function<void()> enter = {});
  // Lines are low afterwards. Within a slice of the scheduler's, or a pulse.
  void stop();

  void captured(const CameraFrame& frame) noexcept override;
  void label(CameraFrame& frame) noexcept override;

  // From any thread.
  [[nodiscard]] std::uint64_t late() const { return scheduler_.counters().late.load(std::memory_order_relaxed); }
  [[nodiscard]] const StrobeCounters& counters() const { return scheduler_.counters(); }
  [[nodiscard]] const LabelCounters& labels() const { return labels_.counters(); }
  // After stop().
  [[nodiscard]] StrobeReport report() const;

 private:
  StrobeSection section_;
  std::unique_ptr<OutputLine> strobe_, trigger_;
  std::unique_ptr<StrobeClock> clock_;
  StrobeScheduler scheduler_;
  FrameLabels labels_;
  std::atomic<std::uint64_t> early_{0};
  std::thread thread_;
};

// Whether this program can do what the section asks, without opening a device: kUsage when it has no GPIO lines.
[[nodiscard]] Outcome<void> check_strobe(const StrobeSection& section, bool live, const std::string& file);
// For the node's summary, with its end; empty when off. live: cameras that take no light from this board are not strobed.
[[nodiscard]] std::string summary_of(const StrobeSection& section, bool live);

}  // namespace srd::firmware
