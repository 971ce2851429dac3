// SPDX-License-Identifier: Apache-2.0
// What a run needs before its first frame: the camera started, and the host, the disk and the strobe opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "firmware/config/instrument.hpp"
#include "firmware/recording/frame_recorder.hpp"
#include "firmware/strobe/strobe.hpp"
#include "firmware/transmit/transmitter.hpp"

namespace srd::firmware {

struct NodeRecording {
  std::filesystem::path folder;             // empty: none is asked for
  std::unique_ptr<FrameRecorder> recorder;  // none: nothing is asked for, or it is refused
  std::string refusal;                      // why there is no recorder for the folder
};

struct StartedNode {
  std::unique_ptr<Transmitter> transmitter;  // none without a host
  NodeRecording recording;
  std::unique_ptr<Strobe> strobe;  // may be none
  std::int64_t period_ns = 0;      // between two frames, as FrameWatchdog has it; 0: not known
};

// Lines for a person go to notify. Problems as run_node has them.
[[nodiscard]] Outcome<StartedNode> start_node(const NodeConfig& config, Instrument& instrument,
                                              const std::function<void(const std::string& lines)>& notify);

}  // namespace srd::firmware
