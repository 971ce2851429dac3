// SPDX-License-Identifier: Apache-2.0
// A configuration brought to life: the camera, and the tracker of the surface that it sees.
#pragma once

#include <memory>

#include "drivers/camera/simulator/scene.hpp"
#include "firmware/config/node_config.hpp"
#include "firmware/loop/frame_deadline.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/recording/recorded_rig.hpp"

namespace srd::firmware {

struct Instrument {
  std::unique_ptr<Camera> camera;           // not started
  std::unique_ptr<FrameDeadline> deadline;  // that the tracker asks; none: no limit
  std::unique_ptr<dsp::SurfaceTracker<float>> tracker;
  std::unique_ptr<CameraDoubts> doubts;  // none: the pose's file says nothing of its errors
  int width = 0, height = 0;             // px, of the calibration
  std::optional<Scene> scene;            // what the simulator renders; none for other cameras
  RecordedRig rig;                       // where the camera is and what it looks at, as read
  // Lines for a person: what was read from where.
  std::string summary;
};

// clock: of the deadline, the steady one unless a test says otherwise.
// Reads every file that the configuration names; kUsage for what the configuration gets wrong, kInput for files that
// cannot be used, kDevice for a camera that is not there.
[[nodiscard]] Outcome<Instrument> make_instrument(const NodeConfig& config, FrameDeadline::Clock clock = {});

}  // namespace srd::firmware
