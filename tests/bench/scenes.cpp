// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/scenes.hpp"

#include <cmath>

namespace srd::bench {

namespace {

Scene parsed(const std::string& text) {
  Outcome<Scene> scene = parse_scene(text, "bench");
  if (!scene) {
    (void)std::fprintf(stderr, "%s\n", scene.error().text().c_str());
    std::abort();
  }
  return std::move(scene).value();
}

// The published prefix with a level of 80 mm. amplitude: mm of the first five modes; the higher ones move less.
void set_waves(Scene& scene, int parameters, double amplitude) {
  static constexpr double kShare[12] = {1, 1, 1, 1, 1, 0.4, 0.4, 0.4, 0.15, 0.15, 0.15, 0.15};
  static constexpr double kHz[12] = {0.31, 0.83, 1.13, 0.97, 1.37, 1.61, 1.73, 1.51, 1.97, 2.03, 1.87, 1.91};
  scene.surface.modes = dsp::ModeList::standard(parameters).value();
  scene.motions.clear();
  for (int j = 0; j < parameters; ++j)
    scene.motions.push_back({scene.surface.modes[j], j == 0 ? 80.0 : 0.0, amplitude * kShare[j], kHz[j], 0.7 + 1.9 * j});
}

}  // namespace

Scene board_scene(int variant) {
  Scene scene = parsed(R"(
name = "board"
[camera]
width = 1920
height = 1080
fx = 1900.0
fy = 1900.0
cx = 959.5
cy = 539.5
distortion = []
[pattern]
rows = 22
columns = 40
square_mm = 20.0
[tank]
refractive_index = 1.0
[image]
blur_px = 0.9
noise = 2.0
)");
  const dsp::Mode level;
  scene.surface.modes = dsp::ModeList::make({&level, 1}).value();
  scene.motions = {{level, 1, 0, 0, 0}};
  scene.seed = static_cast<std::uint64_t>(1 + variant);
  // Subpixel phases differ from corner to corner by perspective, and from board to board by place and turn.
  const double turn = 0.031 + 0.013 * variant, shift = 3.7 * variant;
  scene.pose = look_at({330 + shift, 340 - shift, 1000}, {208 + shift / 3, 392 - shift / 7, 0}, turn).value();
  return scene;
}

Scene flume_scene() { return default_scene(); }

Scene hard_flume_scene() {
  Scene scene = default_scene();
  set_waves(scene, 8, 3);
  scene.blur_px = 1.2;
  scene.noise = 4;
  scene.light.bright = 190;
  scene.light.gradient_percent = 40;
  scene.light.gradient_direction_rad = 0.5;
  // Together they blind about seven of 231 corners at a time, and wander over the pattern.
  scene.glare = {{330, 230, 120, 60, 15, 400}, {700, 250, 90, 100, 15, 400}, {850, 400, -120, -60, 15, 400}};
  return scene;
}

Scene fast_flume_scene() {
  Scene scene = default_scene();
  // Slopes of 0.2 at 5 Hz. Faster and lower waves of the same speed could not be followed by anyone: within a frame
  // they turn by more than a radian.
  static constexpr double kAmplitude[5] = {3, 11.5, 15, 12.5, 18}, kHz[5] = {0.31, 5.1, 4.7, 5.0, 4.6};
  set_waves(scene, 5, 1);
  for (std::size_t j = 0; j < 5; ++j) {
    scene.motions[j].amplitude_mm = kAmplitude[j];
    scene.motions[j].frequency_hz = kHz[j];
  }
  return scene;
}

Scene frame_scene() {
  Scene scene = parsed(R"(
name = "frame"
[camera]
width = 1920
height = 1080
fx = 3225.0
fy = 3225.0
cx = 970.2
cy = 540.1
distortion = [-0.21, 0.09, -0.004, -0.0035, 0.3]
[pose]
centre_mm = [-180.0, 260.0, 950.0]
target_mm = [121.0, 221.0, 0.0]
roll_deg = 0.4
[pattern]
rows = 12
columns = 23
)");
  set_waves(scene, 12, 3);
  return scene;
}

}  // namespace srd::bench
