// SPDX-License-Identifier: Apache-2.0
// Images of a scene: every pixel's ray is traced through the water to the pattern (optics (6)-(8)), and the
// pattern is averaged over the lens's blur and the pixel's area, so that corners lie where the truth says to
// some 1e-4 px. Then the sensor's noise, then an unsharp mask where the scene has one: the truth knows nothing of either.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/camera/simulator/checkerboard.hpp"
#include "drivers/camera/simulator/noise.hpp"
#include "drivers/camera/simulator/pattern_map.hpp"
#include "drivers/camera/simulator/scene.hpp"
#include "drivers/camera/simulator/unsharp_mask.hpp"
#include "drivers/recording/image_file.hpp"
#include "drivers/support/problem.hpp"

namespace srd {

// One thread per object. Nothing is taken from the heap after make.
class Renderer {
 public:
  // kUsage when a corner cannot be seen through the water, or the blur is wider than 1/8 of a square.
  [[nodiscard]] static Outcome<Renderer> make(const Scene& scene);

  // Frame number frame (time frame / rate) into a buffer of the scene's size. The same scene, seed and number
  // give the same image on every machine.
  void render(std::uint64_t frame, const GrayBuffer& image);
  // The dry pattern under the plates, evenly lit as the frames are, without glare.
  void render_reference(const GrayBuffer& image);
  // The frame's grey levels before noise, rounding and limits; width x height, row by row.
  void render_levels(std::uint64_t frame, std::span<float> levels);
  // The same for a surface of the caller's, without glare.
  void render_levels(const dsp::Coefficients<double>& coefficients, std::span<float> levels);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  // Spacing of traced rays (in parts of a pixel where it has parts), and the largest error (px) of those interpolated between them over the scene's
  // motion.
  [[nodiscard]] int grid_step() const { return map_->step(); }
  [[nodiscard]] double grid_error_px() const { return grid_error_px_; }

 private:
  explicit Renderer(const Scene& scene);
  [[nodiscard]] double sampled_grid_error();
  void place_glare(std::uint64_t frame);
  void drawn_row(int v, bool glare);
  void levels_row(int v, bool glare);
  void finish(std::uint64_t frame, bool glare, const GrayBuffer& image);

  // A spot at its place in this frame: brightness = peak factor(v) columns[u - first].
  struct PlacedSpot {
    double v = 0, radius = 0, peak = 0;
    int first = 0, count = 0;
    std::vector<float> columns;
  };

  Scene scene_;
  // PixelArea::kSquare: the mean over fine_ x fine_ parts of the pixel, each drawn as a pixel of drawn_ is, as a normal
  // distribution. Else fine_ is 1, and drawn_ the scene itself.
  int fine_;
  Scene drawn_;
  FilteredCheckerboard board_;
  PixelNoise noise_;
  std::unique_ptr<PatternMap> map_;
  double grid_error_px_ = 0;
  PatternRow pattern_row_;
  std::vector<float> drawn_levels_, levels_;
  std::vector<std::int32_t> levels_q8_;
  std::vector<PlacedSpot> spots_;
  std::unique_ptr<UnsharpMask> mask_;  // null: none
};

// What the tank holds in the dry reference image: air over the plates. The surface's place does not matter
// then.
struct DryTank {
  dsp::SurfaceModel<double> model;
  dsp::Coefficients<double> coefficients;
  dsp::Media<double> media;
};
[[nodiscard]] DryTank dry_tank(const Scene& scene);

// Raw pixels (px) where the camera sees the scene's points in a frame, in the order of Scene::points;
// kOutOfDomain or kNotConverged when one cannot be seen. For the dry reference: the second form.
[[nodiscard]] Result<std::vector<dsp::Vec2<double>>> truth_pixels(const Scene& scene, std::uint64_t frame);
[[nodiscard]] Result<std::vector<dsp::Vec2<double>>> dry_truth_pixels(const Scene& scene);

}  // namespace srd
