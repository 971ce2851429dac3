// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/start.hpp"

#include <random>
#include <utility>

#include "firmware/config/node_key.hpp"
#include "firmware/config/strobe_factory.hpp"

namespace srd::firmware {

namespace {

std::uint64_t random_boot() {
  std::random_device device;
  std::uint64_t boot = 0;
  while (boot == 0) boot = (static_cast<std::uint64_t>(device()) << 32) | device();
  return boot;
}

Outcome<void> start_camera(const NodeConfig& config, Instrument& instrument) {
  Camera& camera = *instrument.camera;
  if (auto started = camera.start(); !started) return started.error();
  if (camera.width() == instrument.width && camera.height() == instrument.height) return {};
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return Problem{Exit::kInput,
                 "the camera's images have another size than its calibration",
                 config.camera->kind + ":" + config.camera->argument,
                 size(instrument.width, instrument.height),
                 size(camera.width(), camera.height()),
                 "use the calibration of this camera and mode"};
}

// None without a host.
Outcome<std::unique_ptr<Transmitter>> start_transmitter(const NodeConfig& config, const Camera& camera) {
  if (config.host.empty()) return std::unique_ptr<Transmitter>();
  TransmitterOptions options;
  options.host = config.host;
  options.sender.from = proto::BootId{*proto::NodeId::make(config.node_id), random_boot()};
  auto key = read_node_key(config);
  if (!key) return key.error();
  options.sender.key = *key;
  options.sender.ring_frames = config.ring_frames;
  options.sender.ring_bytes = config.ring_frames * 600;  // a frame of 12 parameters takes 490 bytes
  options.sender.overwrite = camera.live();
  options.spill = {.folder = config.spill, .frames = config.ring_frames, .frame_bytes = proto::most_frame_bytes(config.modes)};
  return Transmitter::start(options);
}

Outcome<std::unique_ptr<FrameRecorder>> start_recorder(const NodeConfig& config, const Instrument& instrument) {
  std::error_code error;
  if (config.camera->kind == "recording" &&
      std::filesystem::equivalent(config.camera->argument, config.recording.folder, error))
    return Problem{
        Exit::kUsage, "a recording cannot be recorded over itself", config.recording.folder.string(), "another folder", "", ""};
  return FrameRecorder::start(config.recording, instrument.rig, instrument.camera->width(), instrument.camera->height());
}

// A disk that takes no recording ends the run of a person who asked for one by hand. Where the file asks at every start the
// measurement goes on without, as it does when the disk fills up later.
Outcome<NodeRecording> start_recording(const NodeConfig& config, const Instrument& instrument) {
  NodeRecording recording{config.recording.folder, nullptr, {}};
  if (recording.folder.empty()) return recording;
  auto recorder = start_recorder(config, instrument);
  if (recorder) {
    recording.folder = (*recorder)->folder();
    recording.recorder = std::move(*recorder);
  } else {
    const Problem& problem = recorder.error();
    if (!config.recording.numbered_folders || problem.exit != Exit::kInput) return problem;
    recording.refusal = problem.what + ": " + problem.found;
    if (!problem.expected.empty()) recording.refusal += ", expected " + problem.expected;
  }
  return recording;
}

std::string text_of(const NodeRecording& recording) {
  if (recording.folder.empty()) return {};
  if (recording.recorder) return "recording " + recording.folder.string() + "\n";
  return "note      nothing is recorded to " + recording.folder.string() + ": " + recording.refusal +
         "; the measurement goes on\n";
}

}  // namespace

Outcome<StartedNode> start_node(const NodeConfig& config, Instrument& instrument,
                                const std::function<void(const std::string& lines)>& notify) {
  if (auto started = start_camera(config, instrument); !started) return started.error();
  notify(instrument.camera->summary());
  StartedNode node;
  auto transmitter = start_transmitter(config, *instrument.camera);
  if (!transmitter) return transmitter.error();
  node.transmitter = std::move(*transmitter);
  if (node.transmitter && !node.transmitter->spill_note().empty()) notify("spill     " + node.transmitter->spill_note() + "\n");
  auto recording = start_recording(config, instrument);
  if (!recording) return recording.error();
  node.recording = std::move(*recording);
  if (const std::string lines = text_of(node.recording); !lines.empty()) notify(lines);
  auto strobe = open_strobe(config, *instrument.camera);
  if (!strobe) return strobe.error();
  node.strobe = std::move(*strobe);
  const bool paced = instrument.camera->live() && !config.live.trigger_input && config.frame_rate_hz > 0;
  if (paced) node.period_ns = static_cast<std::int64_t>(1e9 / config.frame_rate_hz);
  return node;
}

}  // namespace srd::firmware
