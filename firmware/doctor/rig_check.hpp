// SPDX-License-Identifier: Apache-2.0
// Whether camera and pattern still stand to each other as pose.yml says, from the pattern in two frames: waves tilt the water
// as a camera that has turned would show it, but not twice alike.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "dsp/pose/pose_check.hpp"
#include "firmware/config/instrument.hpp"
#include "firmware/doctor/finding.hpp"

namespace srd::firmware {

class RigCheck {
 public:
  // Between the frames that are compared, by their own times.
  static constexpr std::int64_t kApartNs = 200'000'000;
  // Both outlive the check.
  RigCheck(const NodeConfig& config, const Instrument& instrument) : config_(config), instrument_(instrument) {}

  // The first frame, and the first that is kApartNs later; others are passed over. The pattern may be dry or under still
  // water of any level up to twice the guess and 100 mm.
  void look(const GrayView& image, std::int64_t time_ns);
  // A second frame would decide: the first one differs from the pose.
  [[nodiscard]] bool undecided() const { return first_ && moved(*first_) && !second_; }
  // Nothing is told when no board was found: that is the pattern's own finding.
  void tell(Diagnosis& diagnosis) const;

 private:
  [[nodiscard]] static bool moved(const dsp::PoseCheck& check);
  [[nodiscard]] std::optional<dsp::PoseCheck> check(const GrayView& image);

  const NodeConfig& config_;
  const Instrument& instrument_;
  std::optional<dsp::PoseCheck> first_, second_;
  std::optional<std::int64_t> first_ns_;
  std::string refusal_;  // why the board that was found is not compared
};

}  // namespace srd::firmware
