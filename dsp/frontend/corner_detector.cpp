// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_detector.hpp"

#include <algorithm>

#include "dsp/frontend/edge_profile.hpp"
#include "dsp/frontend/response_top.hpp"
#include "dsp/frontend/sharpening.hpp"

namespace srd::dsp {

namespace {
constexpr int kMinCell = 4;  // px: the smallest bucket of the distance test
}

CornerDetector::CornerDetector(int max_width, int max_height, int max_corners)
    : max_width_(max_width),
      max_height_(max_height),
      max_corners_(static_cast<std::size_t>(max_corners)),
      rows_(3 * (kBand + 2)),
      places_(kBand / 2 + 2),
      bucket_heads_(static_cast<std::size_t>(max_width / kMinCell + 1) * static_cast<std::size_t>(max_height / kMinCell + 1)) {
  maxima_.reserve(16 * max_corners_);
  bucket_next_.reserve(16 * max_corners_);
  corners_.reserve(max_corners_);
  EdgeProfile::prepare();
}

std::span<const CornerFit> CornerDetector::detect(const GrayView& image, const DetectorOptions& options) {
  corners_.clear();
  maxima_.clear();
  overflow_ = 0;
  if (image.width > max_width_ || image.height > max_height_) return {};
  find_maxima(image, options);
  keep_distant(options.min_distance);
  CornerFitOptions fit_options = options.fit;
  const int maxima_left_out = overflow_;
  fit_maxima(image, options, fit_options);
  if (options.measure_sharpening && may_be_sharpened()) {
    const Sharpening measured = measure_sharpening(image, {starts_.data(), start_count_}, fit_options);
    if (measured != fit_options.sharpening) {
      fit_options.sharpening = measured;
      overflow_ = maxima_left_out;
      fit_maxima(image, options, fit_options);
    }
  }
  sharpening_ = fit_options.sharpening;
  return corners_;
}

bool CornerDetector::start_at(const GrayView& image, const Maximum& maximum, const DetectorOptions& options,
                              CornerShape& start) {
  if (!guess_shape(image, maximum.u, maximum.v, options.response.radius, start)) return false;
  if (image.contains(maximum.u, maximum.v, options.response.radius + 2)) {
    ResponseWindow window;
    response_window(image, maximum.u - 2, maximum.v - 2, 5, options.response, window);
    (void)place_at_top(window, 2, 2, start);
  }
  return true;
}

void CornerDetector::fit_maxima(const GrayView& image, const DetectorOptions& options, const CornerFitOptions& fit_options) {
  corners_.clear();
  start_count_ = tried_ = 0;
  // One lens, much the same blur: a corner starts from that of the one before. That one may have been something sharper
  // than the board, as lettering is, from whose blur no corner of the board is found: then from the usual blur.
  constexpr std::int32_t kUsualBlurQ12 = CornerShape{}.blur_q12;
  std::int32_t blur_q12 = kUsualBlurQ12;
  for (const Maximum& maximum : maxima_) {
    CornerFit fit;
    CornerShape start;
    if (!start_at(image, maximum, options, start)) continue;
    ++tried_;
    if (start_count_ < starts_.size()) starts_[start_count_++] = start;
    start.blur_q12 = blur_q12;
    if (!fit_corner(image, start, fit_options, fit)) {
      if (blur_q12 == kUsualBlurQ12) continue;
      start.blur_q12 = kUsualBlurQ12;
      if (!fit_corner(image, start, fit_options, fit)) continue;
    }
    if (corners_.size() == max_corners_) {
      ++overflow_;
      continue;
    }
    blur_q12 = fit.shape.blur_q12;
    fit.corner.response = maximum.response;
    corners_.push_back(fit);
  }
}

// Sharpened edges look sharper than nearly every lens makes them; where they overshoot too much, no corner fits.
bool CornerDetector::may_be_sharpened() const {
  constexpr std::int32_t kSharpQ12 = 4096 * 8 / 10;
  const auto sharp =
      std::count_if(corners_.begin(), corners_.end(), [](const CornerFit& fit) { return fit.shape.blur_q12 < kSharpQ12; });
  return 2 * static_cast<std::size_t>(sharp) > corners_.size() || 2 * corners_.size() < tried_;
}

// Local maxima of 3x3 pixels above the threshold. Bands of columns, so that the rows that one circle spans and three rows
// of responses stay in the first cache; down each band the image is read once.
void CornerDetector::find_maxima(const GrayView& image, const DetectorOptions& options) {
  const int margin = options.response.radius + 1;  // the neighbours need responses too
  Region region = options.region;
  if (region.empty()) region = {0, 0, image.width, image.height};
  const int u0 = std::max(region.u0, margin), u1 = std::min(region.u1, image.width - margin);
  const int v0 = std::max(region.v0, margin), v1 = std::min(region.v1, image.height - margin);
  if (u0 >= u1 || v0 >= v1) return;
  for (int u = u0; u < u1; u += kBand) find_maxima_in_band(image, options, {u, v0, std::min(u + kBand, u1), v1});
}

void CornerDetector::find_maxima_in_band(const GrayView& image, const DetectorOptions& options, const Region& band) {
  const int from = band.u0 - 1, to = band.u1 + 1, n = to - from;
  std::int16_t* above = rows_.data();
  std::int16_t* here = above + kBand + 2;
  std::int16_t* below = here + kBand + 2;
  const auto threshold = static_cast<std::int16_t>(std::clamp(options.threshold, 0, 32767));
  response_row_above(image, band.v0 - 1, from, to, options.response, threshold, above);
  response_row_above(image, band.v0, from, to, options.response, threshold, here);
  for (int v = band.v0; v < band.v1; ++v) {
    response_row_above(image, v + 1, from, to, options.response, threshold, below);
    const int count = row_maxima(above, here, below, n, threshold, places_.data());
    for (int k = 0; k < count; ++k) {
      if (maxima_.size() == maxima_.capacity()) {
        overflow_ += count - k;
        break;
      }
      const int place = places_[static_cast<std::size_t>(k)];
      maxima_.push_back({here[place], from + place, v});
    }
    std::int16_t* const recycled = above;
    above = here;
    here = below;
    below = recycled;
  }
}

// Strongest first; a weaker maximum nearer than min_distance to a kept one goes. Buckets keep it linear.
void CornerDetector::keep_distant(int min_distance) {
  std::sort(maxima_.begin(), maxima_.end(), [](const Maximum& a, const Maximum& b) {
    if (a.response != b.response) return a.response > b.response;
    return a.v != b.v ? a.v < b.v : a.u < b.u;
  });
  const int cell = std::max(min_distance, kMinCell);
  const int columns = max_width_ / cell + 1, rows = max_height_ / cell + 1;
  std::fill_n(bucket_heads_.begin(), static_cast<std::ptrdiff_t>(columns) * rows, -1);
  bucket_next_.clear();
  const std::int64_t limit = static_cast<std::int64_t>(min_distance) * min_distance;
  std::size_t kept = 0;
  for (const Maximum maximum : maxima_) {
    const int cu = maximum.u / cell, cv = maximum.v / cell;
    bool alone = true;
    for (int bv = std::max(cv - 1, 0); alone && bv <= std::min(cv + 1, rows - 1); ++bv)
      for (int bu = std::max(cu - 1, 0); alone && bu <= std::min(cu + 1, columns - 1); ++bu)
        for (int i = bucket_heads_[static_cast<std::size_t>(bv * columns + bu)]; i >= 0;
             i = bucket_next_[static_cast<std::size_t>(i)]) {
          const std::int64_t du = maxima_[static_cast<std::size_t>(i)].u - maximum.u;
          const std::int64_t dv = maxima_[static_cast<std::size_t>(i)].v - maximum.v;
          if (du * du + dv * dv < limit) {
            alone = false;
            break;
          }
        }
    if (!alone) continue;
    int& head = bucket_heads_[static_cast<std::size_t>(cv * columns + cu)];
    bucket_next_.push_back(head);
    head = static_cast<int>(kept);
    maxima_[kept++] = maximum;
  }
  maxima_.resize(kept);
}

}  // namespace srd::dsp
