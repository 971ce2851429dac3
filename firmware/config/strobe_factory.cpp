// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/strobe_factory.hpp"

namespace srd::firmware {

Outcome<std::unique_ptr<Strobe>> open_strobe(const NodeConfig& config, const Camera& camera) {
  if (config.strobe.mode == StrobeMode::kOff || !camera.live()) return std::unique_ptr<Strobe>();
  const FrameTiming timing = camera.timing();
  const std::int64_t window_us = timing.all_rows(0).length_ns() / 1000,
                     needed_us = config.strobe.pulse_us + config.strobe.jitter_us;
  if (!config.strobe.line.empty() && window_us < needed_us)
    return Problem{Exit::kDevice,
                   "the exposure that the camera has is too short for the strobe",
                   config.camera->text(),
                   "all rows integrating for strobe.pulse_us + strobe.jitter_us = " + std::to_string(needed_us) + " us",
                   std::to_string(window_us) + " us",
                   "lengthen camera.exposure_us"};
  return Strobe::open(config.strobe, timing, config.frame_rate_hz, config.region);
}

}  // namespace srd::firmware
