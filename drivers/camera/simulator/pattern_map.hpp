// SPDX-License-Identifier: Apache-2.0
// Which point of the pattern each pixel sees through the water, and how its blur lies there. Rays are traced
// on a grid of pixels (optics (6)-(8)) and interpolated by cubics; pixels whose grid is incomplete are traced
// one by one.
#pragma once

#include <array>
#include <vector>

#include "dsp/optics/ray_trace.hpp"

namespace srd {

// One row of pixels, in squares of the pattern: arguments of FilteredCheckerboard::level.
struct PatternRow {
  std::vector<float> x, y, wx, wy, rho;
  // wx = 0: the pixel sees no pattern (total reflection, a direction that the lens does not have).
};

class PatternMap {
 public:
  // blur_px: standard deviation of the whole blur, > 0. step: of the grid, px. Reserves all memory.
  PatternMap(const dsp::View<double>& view, int width, int height, double square_mm, double blur_px, int step);

  // Traces the grid through a surface. No heap.
  void trace(const dsp::SurfaceModel<double>& model, const dsp::Coefficients<double>& a, const dsp::Media<double>& media);
  // Row v of the surface traced last; vectors of width entries. No heap.
  void row(int v, PatternRow& out);
  // Largest distance (px) between interpolated and traced rays over the middles of the grid's cells, where it
  // is worst.
  [[nodiscard]] double interpolation_error();

  [[nodiscard]] int step() const { return step_; }

 private:
  // What the lens makes of a pixel, whatever the water does.
  struct Sight {
    dsp::Vec3<double> direction;              // in W
    Eigen::Matrix<double, 3, 2> d_direction;  // by pixel
    bool valid = false;
  };
  struct Seen {
    double x, y, wx, wy, rho;
    bool valid;
  };
  [[nodiscard]] Sight sight(double u, double v) const;
  [[nodiscard]] Seen seen(const Sight& sight, double& distance) const;
  [[nodiscard]] bool whole(int column, int row) const;

  dsp::View<double> view_;
  dsp::Vec3<double> centre_;
  int width_, height_, step_, columns_, rows_;  // node (i, j) is pixel ((i - 1) step, (j - 1) step)
  double square_mm_, blur_px_;
  std::vector<Sight> sights_;
  std::vector<Seen> nodes_;
  std::vector<unsigned char> whole_;  // cells whose 4 x 4 nodes are all valid
  std::vector<std::array<float, 4>> cubic_;
  PatternRow line_;  // nodes of one image row, interpolated between grid rows

  dsp::SurfaceModel<double> model_;
  dsp::Coefficients<double> coefficients_;
  dsp::Media<double> media_;
};

}  // namespace srd
