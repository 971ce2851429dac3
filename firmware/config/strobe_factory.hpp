// SPDX-License-Identifier: Apache-2.0
// The strobe that a configuration asks for.
#pragma once

#include <memory>

#include "firmware/config/node_config.hpp"
#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {

// See Strobe::open. Null when the configuration asks for none, or the camera (started) is not live. kDevice when the camera's
// own exposure is too short for the pulses.
[[nodiscard]] Outcome<std::unique_ptr<Strobe>> open_strobe(const NodeConfig& config, const Camera& camera);

}  // namespace srd::firmware
