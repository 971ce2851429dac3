// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/camera_factory.hpp"

#include "drivers/camera/libcamera/libcamera_driver.hpp"
#include "drivers/camera/recording_camera.hpp"
#include "drivers/camera/simulator_camera.hpp"
#include "drivers/camera/v4l2/v4l2_camera.hpp"
#include "drivers/camera/v4l2/v4l2_list.hpp"

namespace srd::firmware {

namespace {

FrameTiming timing_of(const NodeConfig& config, const CameraPlace& place) {
  const LiveCamera& live = config.live;
  FrameTiming timing;
  timing.shutter = live.shutter;
  timing.readout_ns = live.readout_us * 1000;
  timing.exposure_ns = live.exposure_us.value_or(0) * 1000;
  timing.row_fraction = place.centre_row;
  return timing;
}

std::unique_ptr<Camera> make_v4l2(const NodeConfig& config, const CameraPlace& place) {
  const LiveCamera& live = config.live;
  V4l2CameraOptions options;
  options.ask.path = config.camera->argument;
  options.ask.format = live.format;
  options.ask.mosaic = live.mosaic;
  options.ask.width = place.width;
  options.ask.height = place.height;
  options.ask.rate_hz = config.frame_rate_hz;
  options.ask.rate_required = live.rate_required;
  options.ask.exposure_us = live.exposure_us;
  options.ask.gain = live.gain;
  options.ask.sharpness = live.sharpness;
  options.ask.focus = live.focus;
  options.ask.buffers = live.buffers;
  options.timing = timing_of(config, place);
  options.stamp = live.stamp;
  options.trigger_input = live.trigger_input;
  return std::make_unique<V4l2Camera>(std::move(options));
}

Outcome<std::unique_ptr<Camera>> make_libcamera(const NodeConfig& config, const CameraPlace& place) {
  const LiveCamera& live = config.live;
  LibcameraOptions options;
  options.id = config.camera->argument;
  options.width = place.width;
  options.height = place.height;
  options.rate_hz = config.frame_rate_hz;
  options.rate_required = live.rate_required;
  options.exposure_us = live.exposure_us;
  options.gain = live.gain;
  options.sharpness = live.sharpness;
  options.focus = live.focus;
  options.buffers = live.buffers;
  options.timing = timing_of(config, place);
  options.timing.mark = live.stamp.value_or(StampMark::kFrameStart);
  options.trigger_input = live.trigger_input;
  return make_libcamera_camera(options);
}

}  // namespace

Outcome<std::optional<Scene>> scene_of(const NodeConfig& config) {
  if (config.camera->kind == "recording") {
    std::error_code error;
    if (!std::filesystem::is_directory(config.camera->argument, error))
      return Problem{Exit::kInput, "no such folder", config.camera->argument, "a folder with a recording",
                     "",           "check the path"};
  }
  if (config.camera->kind != "simulator") return std::optional<Scene>();
  Scene scene = default_scene();
  if (config.scene) {
    auto read = read_scene(*config.scene);
    if (!read) return read.error();
    scene = *read;
  }
  if (!config.camera->argument.empty()) scene.seed = std::stoull(config.camera->argument);
  return std::optional(std::move(scene));
}

Outcome<std::unique_ptr<Camera>> make_camera(const NodeConfig& config, const std::optional<Scene>& scene,
                                             const CameraPlace& place) {
  if (scene) return std::unique_ptr<Camera>(std::make_unique<SimulatorCamera>(*scene, SimulatorCameraOptions{config.pace, 0}));
  if (config.camera->kind == "recording") {
    RecordingCameraOptions options;
    options.pace = config.pace;
    options.times = {config.recording_rate_hz.value_or(config.frame_rate_hz), config.recording_rate_hz.has_value()};
    options.sample_bits = config.recording_bits;
    return std::unique_ptr<Camera>(std::make_unique<RecordingCamera>(config.camera->argument, options));
  }
  const int width = config.live.width.value_or(place.width), height = config.live.height.value_or(place.height);
  if (width != place.width || height != place.height)
    return Problem{Exit::kUsage,
                   "camera.width_px and camera.height_px are not the calibration's",
                   config.file.string(),
                   std::to_string(place.width) + " x " + std::to_string(place.height),
                   std::to_string(width) + " x " + std::to_string(height),
                   "leave them out, or calibrate the camera in this size"};
  if (config.camera->kind == "libcamera") return make_libcamera(config, place);
  return make_v4l2(config, place);
}

std::string list_cameras() {
  const std::string without = libcamera_is_built() ? "" : " (not in this build)";
  return "kinds of camera, for --camera and camera.source:\n"
         "  libcamera[:ID]      cameras of the board" +
         without +
         "\n"
         "  v4l2:/dev/videoN    capture devices of the kernel\n"
         "  recording:FOLDER    images of a recording\n"
         "  simulator[:SEED]    a rendered flume\n\n" +
         list_v4l2_cameras() + "\n" + list_libcamera_cameras();
}

}  // namespace srd::firmware
