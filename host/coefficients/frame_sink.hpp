// SPDX-License-Identifier: Apache-2.0
// Where frames go once they are in order. Calls come from one thread.
#pragma once

#include <cstdint>

#include "drivers/support/problem.hpp"
#include "proto/messages.hpp"

namespace srd::host {

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // Once a frame, in order within a boot.
  [[nodiscard]] virtual Outcome<void> write(const proto::BootId& from, std::uint64_t sequence,
                                            const proto::CoefficientFrame& frame) = 0;
  // All that was written is safe when this returns: the node may forget it.
  [[nodiscard]] virtual Outcome<void> flush() = 0;
  // Nothing more will be written; before the last flush.
  [[nodiscard]] virtual Outcome<void> finish() { return {}; }
};

}  // namespace srd::host
