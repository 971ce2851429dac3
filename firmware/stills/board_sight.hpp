// SPDX-License-Identifier: Apache-2.0
// What a still of a calibration is judged by: the board in an image, how sharp it is, and how far it lies from where it was.
#pragma once

#include <optional>
#include <vector>

#include "dsp/core/image_view.hpp"
#include "dsp/frontend/board_finder.hpp"

namespace srd::firmware {

struct SightedCorner {
  double u = 0, v = 0, sigma = 0;  // px; the stated deviation of each axis
};

// The largest grid of corners in one image.
struct BoardSight {
  int rows = 0, columns = 0;  // inner corners
  std::vector<SightedCorner> corners;
  double blur_px = 0;  // standard deviation of the edges, lens and pixel together; the median of the corners
  double gap_px = 0;   // from a corner to the one nearest to it, the median
};

// Looks for a board of any size, as srd calibrate does. One thread per object.
class BoardSighter {
 public:
  static constexpr int kMinSide = 4;  // corners: srd calibrate takes no smaller part of a board

  // Images up to width x height px.
  BoardSighter(int width, int height);

  // Nothing: no grid of kMinSide x kMinSide corners at least.
  [[nodiscard]] std::optional<BoardSight> look_at(const GrayView& image);

 private:
  dsp::BoardFinder finder_;
};

// How far the corners lie from where they were, px: what nine tenths of their distances do not exceed, without what the
// corners' own noise makes of it. Nothing: at least a tenth of them is elsewhere, by a third of a square or more.
[[nodiscard]] std::optional<double> shift_px(const BoardSight& before, const BoardSight& now);

}  // namespace srd::firmware
