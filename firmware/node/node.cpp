// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/node.hpp"

#include <utility>

#include "firmware/node/start.hpp"

namespace srd::firmware {

Outcome<RunReport> run_node(const NodeConfig& config, Instrument& instrument, const RunOptions& options,
                            const std::atomic<bool>& stop) {
  Realtime realtime(config.realtime, instrument.camera->live());
  realtime.prepare();
  auto node = start_node(config, instrument, options.notify);
  if (!node) return node.error();
  NodeRun run(instrument, std::move(*node), options, realtime, stop);
  run.measure();
  return run.report();
}

}  // namespace srd::firmware
