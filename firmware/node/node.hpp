// SPDX-License-Identifier: Apache-2.0
// One run of the node: camera, frame loop and transmitter started (start.hpp), watched and ended in order (run.hpp), and
// what became of it (report.hpp).
#pragma once

#include <atomic>

#include "firmware/node/report.hpp"
#include "firmware/node/run.hpp"

namespace srd::firmware {

// Returns after options.frames records, at the camera's end, or soon after stop becomes true (set it from a signal
// handler). Problem: kDevice or kInput when the camera does not start, kUsage when the host is no HOST:PORT, kNetwork when
// there is no socket to send through, kInput when config.recording.numbered_folders is false and the disk takes no recording.
[[nodiscard]] Outcome<RunReport> run_node(const NodeConfig& config, Instrument& instrument, const RunOptions& options,
                                          const std::atomic<bool>& stop);

}  // namespace srd::firmware
