// SPDX-License-Identifier: Apache-2.0
// What a person is told while the node runs: each thing once, when it happens. One thread.
#pragma once

#include <functional>
#include <string>

#include "drivers/camera/camera.hpp"
#include "firmware/recording/frame_recorder.hpp"
#include "firmware/transmit/transmitter.hpp"

namespace srd::firmware {

class Notices {
 public:
  using Notify = std::function<void(const std::string& lines)>;
  // notify outlives the object.
  explicit Notices(const Notify& notify) : notify_(notify) {}

  // Once: the recording has stopped before the run. recorder: may be null.
  void watch_recorder(const FrameRecorder* recorder);
  // Once: the driver's times are impossible. How many became so is in the status and the report.
  void watch_stamps(const Camera& camera);
  // Once for each change of the host's address and of what keeps it from having one. Asks the lookup: takes its moment.
  void watch_host(const Transmitter& transmitter);

 private:
  const Notify& notify_;
  bool recorder_told_ = false, stamps_told_ = false, host_missing_ = false, spill_told_ = false;
  std::string address_told_;
};

}  // namespace srd::firmware
