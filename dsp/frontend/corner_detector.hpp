// SPDX-License-Identifier: Apache-2.0
// All checkerboard corners of an image: response, maxima, minimum distance, subpixel fit. Integer arithmetic.
// Buffers are sized at construction; detect() does not allocate. One thread per object.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dsp/frontend/chess_response.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

struct DetectorOptions {
  ResponseOptions response;
  int threshold = 200;   // >= 0, least response; a corner of contrast C (bright - dark) in focus gives 4 C or more
  int min_distance = 8;  // px between two corners; the stronger one wins
  Region region{};       // where corners may lie; empty: the whole image
  CornerFitOptions fit;
  bool measure_sharpening = true;  // where edges are as sharp as sharpened ones; else fit.sharpening holds
};

class CornerDetector {
 public:
  // Images up to max_width x max_height px; at most max_corners corners and 16 times as many maxima.
  CornerDetector(int max_width, int max_height, int max_corners);

  // Strongest response first. Empty when the image is larger than announced or smaller than the circle.
  [[nodiscard]] std::span<const CornerFit> detect(const GrayView& image, const DetectorOptions& options);
  // Maxima that found no room in the last detect().
  [[nodiscard]] int overflow() const { return overflow_; }
  // The image's sharpening in the last detect(), measured or given.
  [[nodiscard]] const Sharpening& sharpening() const { return sharpening_; }

 private:
  struct Maximum {
    std::int16_t response;
    int u, v;
  };
  static constexpr int kBand = 1024;  // px
  void find_maxima(const GrayView& image, const DetectorOptions& options);
  void find_maxima_in_band(const GrayView& image, const DetectorOptions& options, const Region& band);
  void keep_distant(int min_distance);
  [[nodiscard]] static bool start_at(const GrayView& image, const Maximum& maximum, const DetectorOptions& options,
                                     CornerShape& start);
  void fit_maxima(const GrayView& image, const DetectorOptions& options, const CornerFitOptions& fit_options);
  [[nodiscard]] bool may_be_sharpened() const;

  int max_width_, max_height_;
  std::size_t max_corners_;
  std::vector<std::int16_t> rows_;    // three rows of responses, a band wide
  std::vector<std::int32_t> places_;  // maxima of one row
  std::vector<Maximum> maxima_;
  std::vector<int> bucket_heads_, bucket_next_;
  std::vector<CornerFit> corners_;
  Sharpening sharpening_;
  std::array<CornerShape, 48> starts_;  // of the strongest maxima
  std::size_t start_count_ = 0, tried_ = 0;
  int overflow_ = 0;
};

}  // namespace srd::dsp
