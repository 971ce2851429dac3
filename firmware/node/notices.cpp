// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/notices.hpp"

namespace srd::firmware {

void Notices::watch_recorder(const FrameRecorder* recorder) {
  if (recorder == nullptr || !recorder->stopped() || recorder_told_) return;
  recorder_told_ = true;
  notify_("note      recording to " + recorder->folder().string() + " has stopped: " + recorder->problem() +
          "; the measurement goes on\n");
}

void Notices::watch_stamps(const Camera& camera) {
  if (stamps_told_ || value_of(camera.faults().bad_stamps) == 0) return;
  stamps_told_ = true;
  notify_(
      "note      the camera's driver gives times that cannot be true (standing still, running back, or in the "
      "future): those frames carry the time at which they arrived\n");
}

void Notices::watch_host(const Transmitter& transmitter) {
  if (const std::string spill = transmitter.spill_problem(); !spill.empty() && !spill_told_) {
    spill_told_ = true;
    notify_("note      the spill's disk takes no frames: " + spill + "; they are kept in memory\n");
  }
  if (const std::string address = transmitter.host_address(); address != address_told_) {
    address_told_ = address;
    notify_("host      " + address + "\n");
  }
  const std::string problem = transmitter.host_problem();
  if (problem.empty() == !host_missing_) return;
  host_missing_ = !problem.empty();
  notify_(host_missing_ ? "note      " + problem + "; it is looked up every second, and frames are kept until then\n"
                        : std::string("host      has an address now\n"));
}

}  // namespace srd::firmware
