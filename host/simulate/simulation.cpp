// SPDX-License-Identifier: Apache-2.0
#include "host/simulate/simulation.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/recording/recorded_optics.hpp"
#include "drivers/recording/truth.hpp"
#include "drivers/support/text_file.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPixelsName = "truth_pixels.csv";
constexpr std::string_view kReferencePixelsName = "reference_truth_pixels.csv";
constexpr std::string_view kSceneName = "scene.toml";

using Pixels = std::vector<dsp::Vec2<double>>;

void add_pixel_row(const Pixels& pixels, std::string& text) {
  char number[64];
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int length = std::snprintf(number, sizeof number, "%s%.6f,%.6f", i == 0 ? "" : ",", pixels[i].x(), pixels[i].y());
    text.append(number, static_cast<std::size_t>(length));
  }
  text += '\n';
}

Outcome<void> nothing_is_there(const SimulationOptions& options) {
  if (options.force) return {};
  std::error_code error;
  for (const std::string_view name : {kFramesName, kCalibrationName, kPoseName, kPointsName, kTruthName, kReferenceName,
                                      kOpticsName, kPixelsName, kReferencePixelsName, kSceneName})
    if (fs::exists(options.out / name, error))
      return Problem{Exit::kUsage,
                     "is there already",
                     (options.out / name).string(),
                     "a folder without a recording",
                     "",
                     "name another folder, or add --force to replace what is there"};
  return {};
}

Problem unseen(const Scene& scene, int frame, Errc why) {
  return {Exit::kUsage,   "scene: a corner cannot be seen through the water in frame " + std::to_string(frame),
          scene.name,     "a surface that every ray meets once",
          to_string(why), "lower the amplitudes"};
}

}  // namespace

Outcome<void> write_simulation(const Scene& scene, std::string_view scene_text, const SimulationOptions& options) {
  if (Outcome<void> free = nothing_is_there(options); !free) return free;
  // All that can fail for the scene's sake comes before the first byte is written.
  Truth truth{scene.surface.modes, {}};
  std::string pixel_text;
  for (int i = 0; i < scene.frames; ++i) {
    const auto frame = static_cast<std::uint64_t>(i);
    const Result<Pixels> pixels = truth_pixels(scene, frame);
    if (!pixels) return unseen(scene, i, pixels.error());
    truth.rows.push_back({frame, scene.time_ns(frame), scene.coefficients(frame)});
    add_pixel_row(*pixels, pixel_text);
  }
  Outcome<Renderer> renderer = Renderer::make(scene);
  if (!renderer) return renderer.error();

  Outcome<RecordingWriter> writer = RecordingWriter::create(options.out, options.format, true);
  if (!writer) return writer.error();
  const auto file = [&](std::string_view name) { return options.out / name; };
  for (const Outcome<void>& written :
       {write_calibration(file(kCalibrationName), scene.calibration), write_pose(file(kPoseName), scene.pose),
        write_points(file(kPointsName), scene.points()), write_truth(file(kTruthName), truth),
        write_recorded_optics(options.out, {scene.media, scene.surface}), write_text_file(file(kPixelsName), pixel_text),
        write_text_file(file(kSceneName), scene_text)})
    if (!written) return written;

  GrayImage image{std::vector<std::uint8_t>(static_cast<std::size_t>(scene.width()) * static_cast<std::size_t>(scene.height())),
                  scene.width(), scene.height()};
  const GrayBuffer buffer{image.pixels.data(), image.width, image.height, image.width};
  std::error_code ignored;
  if (scene.reference) {
    const Result<Pixels> pixels = dry_truth_pixels(scene);
    if (!pixels) return unseen(scene, 0, pixels.error());
    std::string text;
    add_pixel_row(*pixels, text);
    if (auto written = write_text_file(file(kReferencePixelsName), text); !written) return written;
    renderer->render_reference(buffer);
    if (auto written = write_gray_image(file(kReferenceName), image.view()); !written) return written;
  } else {
    // A reference of a recording that was here before belongs to other frames.
    fs::remove(file(kReferenceName), ignored);
    fs::remove(file(kReferencePixelsName), ignored);
  }
  for (int i = 0; i < scene.frames; ++i) {
    const auto frame = static_cast<std::uint64_t>(i);
    renderer->render(frame, buffer);
    RecordedFrame row;
    row.sequence = frame;
    row.time_ns = scene.time_ns(frame);
    row.exposure_us = scene.exposure_us;
    if (auto added = writer->add(image.view(), row); !added) return added;
    if (options.progress) options.progress(i + 1, scene.frames);
  }
  return {};
}

}  // namespace srd::host
