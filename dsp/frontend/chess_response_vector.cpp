// SPDX-License-Identifier: Apache-2.0
// The response and its maxima, one source for every vector unit; equal to the scalar definition bit for bit.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "dsp/frontend/chess_response.hpp"
#include "dsp/frontend/ring.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dsp/frontend/chess_response_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace srd::dsp {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // a machine without any of the vector units

void ResponseRow(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  scalar::response_row(image, v, u0, u1, options, out);
}

void ResponseRowAbove(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t /*threshold*/,
                      std::int16_t* out) {
  scalar::response_row(image, v, u0, u1, options, out);
}

int RowMaxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n, std::int16_t threshold,
              std::int32_t* at) {
  return scalar::row_maxima(above, here, below, n, threshold, at);
}

void ResponseWindowOf(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window) {
  scalar::response_window(image, u0, v0, side, options, window);
}

WindowPeak WindowPeakOf(const ResponseWindow& window, std::int16_t threshold) { return scalar::window_peak(window, threshold); }

#else

namespace hn = hwy::HWY_NAMESPACE;

// The difference of two vectors of bytes, 16 bits a pixel: first half, second half.
template <class V>
struct Halves {
  V low, high;
};

template <class D8>
using Wider = hn::Rebind<std::int16_t, hn::Half<D8> >;

template <class D8, class V8>
HWY_INLINE Halves<hn::Vec<Wider<D8> > > widen(D8 /*d8*/, V8 v) {
  const hn::Half<D8> half;
  const Wider<D8> d16;
  return {hn::PromoteTo(d16, hn::LowerHalf(half, v)), hn::PromoteTo(d16, hn::UpperHalf(half, v))};
}

// The pixel of sample n of a vector that starts at p. Row and column are constants, so that the compiler keeps one pointer
// a row of the circle.
template <int kRadius, std::size_t kSample, class D8>
HWY_INLINE hn::Vec<D8> sample(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride) {
  constexpr Offset at = ring(kRadius)[kSample];
  return hn::LoadU(d8, p + at.y * stride + at.x);
}

// With two opposite samples a, c and the two across b, d:
// |(a+c) - (b+d)| - |a-c| - |b-d| = 2 max(min(a,c) - max(b,d), min(b,d) - max(a,c)), all in bytes but the last sum.
template <int kRadius, std::size_t kSample, class D8, class V16>
HWY_INLINE void add_group(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride, V16& low, V16& high) {
  const auto a = sample<kRadius, kSample>(d8, p, stride), b = sample<kRadius, kSample + 4>(d8, p, stride);
  const auto c = sample<kRadius, kSample + 8>(d8, p, stride), d = sample<kRadius, kSample + 12>(d8, p, stride);
  const auto low1 = hn::Min(a, c), high1 = hn::Max(a, c), low2 = hn::Min(b, d), high2 = hn::Max(b, d);
  const auto more = widen(d8, hn::Or(hn::SaturatedSub(low1, high2), hn::SaturatedSub(low2, high1)));
  const auto less = widen(d8, hn::Min(hn::SaturatedSub(high2, low1), hn::SaturatedSub(high1, low2)));
  low = hn::Add(low, hn::Sub(more.low, less.low));
  high = hn::Add(high, hn::Sub(more.high, less.high));
}

template <class D8, class V8, class V16>
HWY_INLINE void add_wide(D8 d8, V8 v, V16& low, V16& high) {
  const auto wide = widen(d8, v);
  low = hn::Add(low, wide.low);
  high = hn::Add(high, wide.high);
}

template <int kRadius, class D8, class V16, std::size_t... kSamples>
HWY_INLINE void add_circle(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride, V16& low, V16& high,
                           std::index_sequence<kSamples...>) {
  (add_wide(d8, sample<kRadius, kSamples>(d8, p, stride), low, high), ...);
}

// floor(|5 circle - 16 cross| / 5): |..| <= 20400 fits, and x / 5 = (x * 52429) >> 18 for x < 2^16.
template <class D16, class V16>
HWY_INLINE V16 mean_term(D16 d16, V16 circle, V16 cross) {
  const hn::RebindToUnsigned<D16> du16;
  const auto five = hn::Add(hn::ShiftLeft<2>(circle), circle);
  const auto size = hn::BitCast(du16, hn::Abs(hn::Sub(five, hn::ShiftLeft<4>(cross))));
  return hn::BitCast(d16, hn::ShiftRight<2>(hn::MulHigh(size, hn::Set(du16, 52429))));
}

// One vector of pixels from p.
template <int kRadius, bool kMeanTerm, class D8>
HWY_INLINE void responses(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride, std::int16_t* HWY_RESTRICT out) {
  const Wider<D8> d16;
  auto low = hn::Zero(d16), high = hn::Zero(d16);
  add_group<kRadius, 0>(d8, p, stride, low, high);
  add_group<kRadius, 1>(d8, p, stride, low, high);
  add_group<kRadius, 2>(d8, p, stride, low, high);
  add_group<kRadius, 3>(d8, p, stride, low, high);
  low = hn::Add(low, low);
  high = hn::Add(high, high);
  if constexpr (kMeanTerm) {
    auto circle_low = hn::Zero(d16), circle_high = hn::Zero(d16), cross_low = hn::Zero(d16), cross_high = hn::Zero(d16);
    add_circle<kRadius>(d8, p, stride, circle_low, circle_high, std::make_index_sequence<16>());
    for (const std::uint8_t* at : {p, p + 1, p - 1, p + stride, p - stride})
      add_wide(d8, hn::LoadU(d8, at), cross_low, cross_high);
    low = hn::Sub(low, mean_term(d16, circle_low, cross_low));
    high = hn::Sub(high, mean_term(d16, circle_high, cross_high));
  }
  hn::StoreU(low, d16, out);
  hn::StoreU(high, d16, out + hn::Lanes(d16));
}

template <int kRadius, bool kMeanTerm>
HWY_INLINE void row(const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride, int n, std::int16_t* HWY_RESTRICT out) {
  const hn::CappedTag<std::uint8_t, 32> wide;
  const hn::CappedTag<std::uint8_t, 16> narrow;
  const int wide_step = static_cast<int>(hn::Lanes(wide)), narrow_step = static_cast<int>(hn::Lanes(narrow));
  int i = 0;
  for (; i + wide_step <= n; i += wide_step) responses<kRadius, kMeanTerm>(wide, p + i, stride, out + i);
  for (; i + narrow_step <= n; i += narrow_step) responses<kRadius, kMeanTerm>(narrow, p + i, stride, out + i);
  // The rest overlaps what is done: the same numbers again.
  if (i < n) responses<kRadius, kMeanTerm>(narrow, p + n - narrow_step, stride, out + n - narrow_step);
}

// Calls f with the options as constants.
template <class F>
HWY_INLINE void with_constants(const ResponseOptions& options, F&& f) {
  using Five = std::integral_constant<int, 5>;
  using Ten = std::integral_constant<int, 10>;
  if (options.radius == 10)
    options.mean_term ? f(Ten(), std::true_type()) : f(Ten(), std::false_type());
  else
    options.mean_term ? f(Five(), std::true_type()) : f(Five(), std::false_type());
}

void ResponseRow(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  constexpr int kNarrowest = 16;  // the narrowest vector
  if (u1 - u0 < kNarrowest) return scalar::response_row(image, v, u0, u1, options, out);
  with_constants(options,
                 [&](auto radius, auto mean) { row<radius(), mean()>(image.row(v) + u0, image.stride_bytes, u1 - u0, out); });
}

// What a group of four samples adds to the response at most, halved: positive where both samples of a pair outshine both of
// the other, as at corners and hardly anywhere else.
template <int kRadius, std::size_t kSample, class D8>
HWY_INLINE hn::Vec<D8> most_of_group(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride) {
  const auto a = sample<kRadius, kSample>(d8, p, stride), b = sample<kRadius, kSample + 4>(d8, p, stride);
  const auto c = sample<kRadius, kSample + 8>(d8, p, stride), d = sample<kRadius, kSample + 12>(d8, p, stride);
  return hn::Or(hn::SaturatedSub(hn::Min(a, c), hn::Max(b, d)), hn::SaturatedSub(hn::Min(b, d), hn::Max(a, c)));
}

// Apart, so that what it needs takes no registers from the loop that seldom calls it.
template <int kRadius, bool kMeanTerm, class D8>
HWY_NOINLINE void responses_apart(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride,
                                  std::int16_t* HWY_RESTRICT out) {
  responses<kRadius, kMeanTerm>(d8, p, stride, out);
}

template <int kRadius, bool kMeanTerm, class D8>
HWY_INLINE void responses_above(D8 d8, const std::uint8_t* HWY_RESTRICT p, std::ptrdiff_t stride, std::int16_t threshold,
                                std::int16_t* HWY_RESTRICT out) {
  const auto sum =
      hn::SaturatedAdd(hn::SaturatedAdd(most_of_group<kRadius, 0>(d8, p, stride), most_of_group<kRadius, 1>(d8, p, stride)),
                       hn::SaturatedAdd(most_of_group<kRadius, 2>(d8, p, stride), most_of_group<kRadius, 3>(d8, p, stride)));
  // Twice the sum is not above the threshold, and the mean term only lowers it. 255 may stand for more.
  const auto half = hn::Set(d8, static_cast<std::uint8_t>(std::clamp(threshold / 2, 0, 254)));
  if (!hn::AllTrue(d8, hn::Eq(hn::SaturatedSub(sum, half), hn::Zero(d8))))
    return responses_apart<kRadius, kMeanTerm>(d8, p, stride, out);
  const Wider<D8> d16;
  hn::StoreU(hn::Set(d16, threshold), d16, out);
  hn::StoreU(hn::Set(d16, threshold), d16, out + hn::Lanes(d16));
}

void ResponseRowAbove(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t threshold,
                      std::int16_t* out) {
  const hn::CappedTag<std::uint8_t, 32> d;
  const int step = static_cast<int>(hn::Lanes(d)), n = u1 - u0;
  if (n < step) return ResponseRow(image, v, u0, u1, options, out);
  const std::uint8_t* p = image.row(v) + u0;
  with_constants(options, [&](auto radius, auto mean) {
    int i = 0;
    for (; i + step <= n; i += step) responses_above<radius(), mean()>(d, p + i, image.stride_bytes, threshold, out + i);
    if (i < n) responses_above<radius(), mean()>(d, p + n - step, image.stride_bytes, threshold, out + n - step);
  });
}

int RowMaxima(const std::int16_t* HWY_RESTRICT above, const std::int16_t* HWY_RESTRICT here,
              const std::int16_t* HWY_RESTRICT below, int n, std::int16_t threshold, std::int32_t* HWY_RESTRICT at) {
  const hn::CappedTag<std::int16_t, 16> d;
  const int step = static_cast<int>(hn::Lanes(d));
  const auto limit = hn::Set(d, threshold);
  int count = 0, i = 1;
  const auto add_maxima = [&](int from) {
    const auto r = hn::LoadU(d, here + from);
    // Greater than all that come before in reading order, not less than all that come after.
    const auto before = hn::Max(hn::Max(hn::LoadU(d, above + from - 1), hn::LoadU(d, above + from)),
                                hn::Max(hn::LoadU(d, above + from + 1), hn::LoadU(d, here + from - 1)));
    const auto after = hn::Max(hn::Max(hn::LoadU(d, below + from - 1), hn::LoadU(d, below + from)),
                               hn::Max(hn::LoadU(d, below + from + 1), hn::LoadU(d, here + from + 1)));
    const auto maximum = hn::AndNot(hn::Lt(r, after), hn::And(hn::Gt(r, limit), hn::Gt(r, before)));
    if (hn::AllFalse(d, maximum)) return;
    HWY_ALIGN std::int16_t flag[hn::MaxLanes(d)];
    hn::Store(hn::VecFromMask(d, maximum), d, flag);
    for (int k = 0; k < step; ++k)
      if (flag[k] != 0) at[count++] = from + k;
  };
  // Four vectors at a time: most of a row has nothing above the threshold.
  for (; i + 4 * step + 1 <= n; i += 4 * step) {
    const auto most = hn::Max(hn::Max(hn::LoadU(d, here + i), hn::LoadU(d, here + i + step)),
                              hn::Max(hn::LoadU(d, here + i + 2 * step), hn::LoadU(d, here + i + 3 * step)));
    if (hn::AllFalse(d, hn::Gt(most, limit))) continue;
    for (int part = 0; part < 4; ++part) add_maxima(i + part * step);
  }
  for (; i + step + 1 <= n; i += step) add_maxima(i);
  if (i + 1 < n) {
    const int rest = scalar::row_maxima(above + i - 1, here + i - 1, below + i - 1, n - i + 1, threshold, at + count);
    for (int k = 0; k < rest; ++k) at[count + k] += i - 1;
    count += rest;
  }
  return count;
}

// Whole vectors of pixels from column 'first'; what they hold beyond the window's right end is blotted out.
template <int kRadius, bool kMeanTerm>
HWY_INLINE void window_rows(const GrayView& image, int first, int columns, ResponseWindow& window) {
  const hn::CappedTag<std::uint8_t, 16> d;
  const hn::CappedTag<std::int16_t, 8> d16;
  const int skipped = window.u0 - first, last = window.side / 8 * 8;
  const auto inside = hn::FirstN(d16, static_cast<std::size_t>(window.side - last));
  const auto nothing = hn::Set(d16, -32768);
  HWY_ALIGN std::int16_t beside[2 * ResponseWindow::kStride];
  for (int i = 0; i < window.side; ++i) {
    const std::uint8_t* p = image.row(window.v0 + i) + first;
    std::int16_t* row = window.at.data() + i * ResponseWindow::kStride;
    std::int16_t* to = skipped == 0 ? row : beside;
    for (int j = 0; j < columns; j += 16) responses<kRadius, kMeanTerm>(d, p + j, image.stride_bytes, to + j);
    for (int j = 0; skipped > 0 && j < window.side; j += 8) hn::Store(hn::LoadU(d16, to + skipped + j), d16, row + j);
    if (last < window.side) hn::Store(hn::IfThenElse(inside, hn::Load(d16, row + last), nothing), d16, row + last);
  }
}

void ResponseWindowOf(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window) {
  const int columns = (side + 15) / 16 * 16;
  const int first = std::min(u0, image.width - options.radius - columns);
  if (first < options.radius) return scalar::response_window(image, u0, v0, side, options, window);
  window.u0 = u0;
  window.v0 = v0;
  window.side = side;
  with_constants(options, [&](auto radius, auto mean) { window_rows<radius(), mean()>(image, first, columns, window); });
}

// Lanes of a row from column j that are further than the first maximum's plateau from it along u.
HWY_INLINE hn::Mask<hn::CappedTag<std::int16_t, 8> > beyond(hn::CappedTag<std::int16_t, 8> d, int j, int column, int plateau) {
  return hn::Gt(hn::Abs(hn::Sub(hn::Iota(d, static_cast<std::int16_t>(j)), hn::Set(d, static_cast<std::int16_t>(column)))),
                hn::Set(d, static_cast<std::int16_t>(plateau)));
}

// Whether any place apart from the first maximum's plateau is as strong as 'least': most often none is.
HWY_INLINE bool has_rival(const ResponseWindow& window, const WindowPeak& peak, std::int16_t least, int plateau) {
  const hn::CappedTag<std::int16_t, 8> d;
  const auto none = hn::Set(d, -32768);
  auto most = none;
  for (int j = 0; j < window.side; j += 8) {
    const auto outside = beyond(d, j, peak.column, plateau);
    const int above = std::clamp(peak.row - plateau, 1, window.side - 1),
              below = std::min(peak.row + plateau + 1, window.side - 1);
    int i = 1;
    for (; i < above; ++i) most = hn::Max(most, hn::Load(d, window.row(i) + j));
    for (; i < below; ++i) most = hn::Max(most, hn::IfThenElse(outside, hn::Load(d, window.row(i) + j), none));
    for (; i + 1 < window.side; ++i) most = hn::Max(most, hn::Load(d, window.row(i) + j));
  }
  return !hn::AllFalse(d, hn::Gt(most, hn::Set(d, static_cast<std::int16_t>(least - 1))));
}

WindowPeak WindowPeakOf(const ResponseWindow& window, std::int16_t threshold) {
  constexpr int kPlateau = 4;
  const hn::CappedTag<std::int16_t, 8> d;
  // Each lane keeps its largest response and the first place where it met it.
  auto most = hn::Set(d, -32768), place = hn::Zero(d);
  const auto column = hn::Iota(d, 0);
  for (int i = 0; i < window.side; ++i)
    for (int j = 0; j < window.side; j += 8) {
      const auto r = hn::Load(d, window.row(i) + j);
      const auto here = hn::Add(column, hn::Set(d, static_cast<std::int16_t>(i * ResponseWindow::kStride + j)));
      place = hn::IfThenElse(hn::Gt(r, most), here, place);
      most = hn::Max(most, r);
    }
  HWY_ALIGN std::int16_t responses_of[8], places_of[8];
  hn::Store(most, d, responses_of);
  hn::Store(place, d, places_of);
  WindowPeak peak;
  int first = 32767;
  for (int k = 0; k < 8; ++k)
    if (responses_of[k] > peak.response || (responses_of[k] == peak.response && places_of[k] < first)) {
      peak.response = responses_of[k];
      first = places_of[k];
    }
  peak.row = first / ResponseWindow::kStride;
  peak.column = first % ResponseWindow::kStride;
  if (peak.response <= threshold) return peak;
  const int least = std::max<int>(threshold + 1, (peak.response + 1) / 2);
  if (has_rival(window, peak, static_cast<std::int16_t>(least), kPlateau))
    peak.another = scalar::window_peak(window, threshold).another;
  return peak;
}

#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace srd::dsp
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace srd::dsp {

namespace {
HWY_EXPORT(ResponseRow);
HWY_EXPORT(ResponseRowAbove);
HWY_EXPORT(RowMaxima);
HWY_EXPORT(ResponseWindowOf);
HWY_EXPORT(WindowPeakOf);
}  // namespace

void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(ResponseRow)(image, v, u0, u1, options, out);
}

void response_row_above(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t threshold,
                        std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(ResponseRowAbove)(image, v, u0, u1, options, threshold, out);
}

int row_maxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n, std::int16_t threshold,
               std::int32_t* at) {
  return HWY_DYNAMIC_DISPATCH(RowMaxima)(above, here, below, n, threshold, at);
}

void response_window(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window) {
  HWY_DYNAMIC_DISPATCH(ResponseWindowOf)(image, u0, v0, side, options, window);
}

WindowPeak window_peak(const ResponseWindow& window, std::int16_t threshold) {
  return HWY_DYNAMIC_DISPATCH(WindowPeakOf)(window, threshold);
}

}  // namespace srd::dsp
#endif
