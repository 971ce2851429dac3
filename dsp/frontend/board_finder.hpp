// SPDX-License-Identifier: Apache-2.0
// The boards of an image: corners, and which is which. The least distance between two corners follows the squares that
// are seen: where they are smaller than announced, it is halved and the image searched again.
// Buffers are sized at construction; find() does not allocate. One thread per object.
#pragma once

#include <span>
#include <vector>

#include "dsp/frontend/corner_detector.hpp"
#include "dsp/frontend/grid_labelling.hpp"

namespace srd::dsp {

class BoardFinder {
 public:
  // Images up to max_width x max_height px, with at most max_corners corners.
  BoardFinder(int max_width, int max_height, int max_corners);

  // The largest grid, or the board of a known size: see GridLabeller. grids() has them all.
  [[nodiscard]] Result<CornerGrid> find(const GrayView& image, const DetectorOptions& options);
  [[nodiscard]] Result<CornerGrid> find(const GrayView& image, const DetectorOptions& options, BoardSize board);
  // What the grids' cells number; valid until the next find().
  [[nodiscard]] std::span<const CornerFit> corners() const { return corners_; }
  [[nodiscard]] std::span<const CornerGrid> grids() const { return labeller_.grids(); }
  // The image's sharpening in the last find(), measured or given.
  [[nodiscard]] const Sharpening& sharpening() const { return detector_.sharpening(); }

 private:
  template <class Label>
  Result<CornerGrid> search(const GrayView& image, const DetectorOptions& options, Label&& label);
  [[nodiscard]] int labelled() const;

  [[nodiscard]] bool fit_sighted(const GrayView& image, const DetectorOptions& options);

  std::size_t max_corners_;
  CornerDetector detector_;
  GridLabeller labeller_;
  std::vector<CornerFit> corners_;
};

}  // namespace srd::dsp
