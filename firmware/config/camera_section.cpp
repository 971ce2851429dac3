// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/camera_section.hpp"

#include "drivers/camera/frame_pool.hpp"
#include "drivers/camera/v4l2/v4l2_format.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/text_file.hpp"
#include "drivers/support/toml_reader.hpp"
#include "firmware/config/node_config.hpp"

namespace srd::firmware {

namespace {

void read_live(TomlTable& camera, LiveCamera& live) {
  live.rate_required = camera.has("frame_rate_hz");
  if (auto format = camera.text("format")) {
    if (is_v4l2_format_name(*format))
      live.format = *format;
    else
      camera.complain("format", "one of " + v4l2_format_names(), "\"" + *format + "\"");
  }
  if (auto mosaic = camera.choice("mosaic", {"green", "all"}))
    live.mosaic = *mosaic == "all" ? MosaicGray::kAll : MosaicGray::kGreen;
  const auto size = [&](const char* key) -> std::optional<int> {
    const auto px = camera.integer(key, {16, 16384, "px"});
    return px ? std::optional(static_cast<int>(*px)) : std::nullopt;
  };
  live.width = size("width_px");
  live.height = size("height_px");
  live.exposure_us = camera.integer("exposure_us", {1, 1e6, "us"});
  live.gain = camera.number("gain", {0, 1e6});
  live.sharpness = camera.number("sharpness", {0, 1e6});
  live.focus = camera.number("focus", {0, 1e6});
  if (auto buffers = camera.integer("buffers", {3, FramePool::kMaxBuffers})) live.buffers = static_cast<int>(*buffers);
  if (auto shutter = camera.choice("shutter", {"global", "rolling"}))
    live.shutter = *shutter == "rolling" ? Shutter::kRolling : Shutter::kGlobal;
  if (auto readout = camera.integer("readout_us", {0, 1e6, "us"})) live.readout_us = *readout;
  if (live.shutter == Shutter::kRolling && !camera.has("readout_us"))
    camera.missing("readout_us", "the time from the first row's readout to the last one's, us: a rolling shutter has one");
  if (auto stamp = camera.choice("stamp", {"frame-start", "frame-end", "exposure-start"}))
    live.stamp = *stamp == "frame-start" ? StampMark::kFrameStart
                 : *stamp == "frame-end" ? StampMark::kFrameEnd
                                         : StampMark::kExposureStart;
  if (auto trigger = camera.boolean("trigger_input")) live.trigger_input = *trigger;
}

}  // namespace

std::string CameraSource::kinds() { return "libcamera[:ID], v4l2:/dev/videoN, recording:FOLDER or simulator[:SEED]"; }

Outcome<CameraSource> CameraSource::parse(const std::string& text) {
  CameraSource source;
  const std::size_t colon = text.find(':');
  source.kind = text.substr(0, colon);
  if (colon != std::string::npos) source.argument = text.substr(colon + 1);
  const auto wrong = [&](std::string expected) {
    return Problem{Exit::kUsage, "camera source", "", std::move(expected), "\"" + text + "\"", ""};
  };
  if (source.kind == "recording") {
    if (source.argument.empty()) return wrong("recording:FOLDER");
  } else if (source.kind == "simulator") {
    if (source.argument.find_first_not_of("0123456789") != std::string::npos || source.argument.size() > 18)
      return wrong("simulator or simulator:SEED with a whole number");
  } else if (source.kind == "v4l2") {
    if (!source.argument.starts_with("/")) return wrong("v4l2:/dev/videoN (a path that stays the same: /dev/v4l/by-id/..)");
  } else if (source.kind == "libcamera") {
    if (colon != std::string::npos && source.argument.empty())
      return wrong("libcamera, or libcamera:ID with a name of --list-cameras");
  } else {
    return wrong(kinds());
  }
  return source;
}

void read_camera(TomlTable camera, const std::filesystem::path& folder, NodeConfig& config) {
  if (auto source = camera.text("source")) {
    if (auto parsed = CameraSource::parse(*source))
      config.camera = *parsed;
    else
      camera.complain("source", parsed.error().expected, parsed.error().found);
  }
  if (auto rate = camera.choice("rate", {"camera", "max"})) config.pace = *rate == "max" ? Pace::kMax : Pace::kCamera;
  if (auto rate = camera.number("frame_rate_hz", {0.001, 10000, "Hz"})) config.frame_rate_hz = *rate;
  if (auto bits = camera.integer("bits", {kMinSampleBits, kMaxSampleBits})) config.recording_bits = static_cast<int>(*bits);
  if (auto scene = camera.text("scene")) config.scene = folder / *scene;
  read_live(camera, config.live);
  if (const double period_us = 1e6 / config.frame_rate_hz; static_cast<double>(config.live.exposure_us.value_or(0)) > period_us)
    camera.complain("exposure_us",
                    "at most the time between two frames, " + number_text(period_us) + " us at " +
                        number_text(config.frame_rate_hz) + " Hz",
                    std::to_string(*config.live.exposure_us), "a shorter exposure, or a lower camera.frame_rate_hz");
}

}  // namespace srd::firmware
