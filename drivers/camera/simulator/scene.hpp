// SPDX-License-Identifier: Apache-2.0
// What the simulator renders: a camera over a checkerboard under moving water, in a TOML file.
// Frames and symbols: optics page. Keys that a file leaves out have the built-in scene's values.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace srd {

// Inner corners at X = row * square_mm, Y = column * square_mm, Z = 0; squares go on for border_squares
// beyond them.
struct BoardPattern {
  int rows = 11;
  int columns = 21;
  double square_mm = 20;
  int border_squares = 1;
  bool origin_dark = true;  // the square with corners (0, 0) and (1, 1)
  double margin = 0.5;      // grey of what lies around: 0 as a dark square, 1 as a bright one
};

// a_j(t) = mean + amplitude sin(2 pi frequency t + phase)
struct ModeMotion {
  dsp::Mode mode;
  double mean_mm = 0;
  double amplitude_mm = 0;
  double frequency_hz = 0;
  double phase_rad = 0;
};

struct Light {
  double dark = 20;  // grey level of a dark square at the image's centre, 0..255
  double bright = 220;
  double gradient_percent = 0;        // change of brightness across the image, of that at the centre
  double gradient_direction_rad = 0;  // 0: brighter to the right, pi/2: brighter downwards
  double vignette_percent = 0;        // fall of brightness at the image's corners
};

// Light that the surface mirrors into the camera: peak exp(-r^2 / (2 radius^2)) grey levels on top.
struct GlareSpot {
  double u_px = 0, v_px = 0;  // at time 0; a spot that leaves the image comes in on the other side
  double speed_u_px_s = 0, speed_v_px_s = 0;
  double radius_px = 10;
  double peak = 255;
};

// What a pixel averages over, after the lens.
enum class PixelArea : std::uint8_t {
  kNormal,  // a normal distribution of a square's variance, 1/12 px^2 an axis: the whole blur is sqrt(blur_px^2 + 1/12)
  kSquare,  // its square, evenly
};

struct Scene {
  std::string name;
  std::uint64_t seed = 1;  // of the noise
  int frames = 60;
  bool reference = true;  // also render the dry pattern
  Calibration calibration;
  double rate_hz = 50;
  std::uint32_t exposure_us = 0;
  dsp::Pose<double> pose;
  BoardPattern pattern;
  dsp::Media<double> media;
  dsp::SurfaceModel<double> surface;
  std::vector<ModeMotion> motions;  // one a mode, in the order of surface.modes
  Light light;
  // Standard deviation of the lens's blur, a normal distribution, before the pixel's area.
  double blur_px = 0.7;  // 0.5 to 20; with PixelArea::kSquare from 0.2
  PixelArea pixel = PixelArea::kNormal;
  double noise = 1.5;              // sigma, grey levels, of the sensor
  double sharpen_amount = 0;       // unsharp mask after the noise: level + amount (level - its blur), 0..3
  double sharpen_radius_px = 1.0;  // standard deviation of that blur, a normal distribution, 0.5..4 px
  std::vector<GlareSpot> glare;

  [[nodiscard]] int width() const { return calibration.image_width; }
  [[nodiscard]] int height() const { return calibration.image_height; }
  [[nodiscard]] dsp::View<double> view() const { return {calibration.camera, pose}; }
  // Row by row: index = row * columns + column.
  [[nodiscard]] Points points() const;
  [[nodiscard]] std::int64_t time_ns(std::uint64_t frame) const;
  [[nodiscard]] dsp::Coefficients<double> coefficients(std::uint64_t frame) const;
};

// Camera at centre (mm), looking at target; at roll 0 the image's u runs with Y as far as the direction
// allows, and a positive roll turns the camera clockwise as seen from behind. kSingular when it looks along
// Y.
[[nodiscard]] Result<dsp::Pose<double>> look_at(const dsp::Vec3<double>& centre, const dsp::Vec3<double>& target,
                                                double roll_rad);

// kUsage with file and line for everything that is wrong in the file.
[[nodiscard]] Outcome<Scene> read_scene(const std::filesystem::path& path);
[[nodiscard]] Outcome<Scene> parse_scene(std::string_view text, const std::string& name);
// The built-in scene, and the commented file that it is made from.
[[nodiscard]] const Scene& default_scene();
[[nodiscard]] std::string_view default_scene_text();

}  // namespace srd
