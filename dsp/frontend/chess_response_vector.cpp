// The response and its maxima, one source for every vector unit; equal to the scalar definition bit for bit.
#include <algorithm>
#include <cstdlib>

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

int RowMaxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n,
              std::int16_t threshold, std::int32_t* at) {
  return scalar::row_maxima(above, here, below, n, threshold, at);
}

void ResponseWindowOf(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options,
                      ResponseWindow& window) {
  scalar::response_window(image, u0, v0, side, options, window);
}

WindowPeak WindowPeakOf(const ResponseWindow& window, std::int16_t threshold) {
  return scalar::window_peak(window, threshold);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// Pixels in even and in odd places, 16 bits each.
template <class V>
struct EvenOdd {
  V even, odd;
};

template <class D16, class V8>
HWY_INLINE EvenOdd<hn::Vec<D16>> widen(D16 d16, V8 v) {
  const auto both = hn::BitCast(d16, v);
  return {hn::And(both, hn::Set(d16, 0x00FF)), hn::BitCast(d16, hn::ShiftRight<8>(hn::BitCast(hn::RebindToUnsigned<D16>(), both)))};
}

// One vector of pixels from p. With two opposite samples a, c and the two across b, d:
// |(a+c) - (b+d)| - |a-c| - |b-d| = 2 max(min(a,c) - max(b,d), min(b,d) - max(a,c)), all in bytes but the last sum.
template <bool kMeanTerm, class D8>
HWY_INLINE void responses(D8 d8, const std::uint8_t* HWY_RESTRICT p, const std::ptrdiff_t* HWY_RESTRICT at,
                          std::ptrdiff_t stride, std::int16_t* HWY_RESTRICT out) {
  const hn::Repartition<std::int16_t, D8> d16;
  auto even = hn::Zero(d16), odd = hn::Zero(d16);
  auto circle_even = hn::Zero(d16), circle_odd = hn::Zero(d16);
  for (int n = 0; n < 4; ++n) {
    const auto a = hn::LoadU(d8, p + at[n]), b = hn::LoadU(d8, p + at[n + 4]);
    const auto c = hn::LoadU(d8, p + at[n + 8]), d = hn::LoadU(d8, p + at[n + 12]);
    const auto low1 = hn::Min(a, c), high1 = hn::Max(a, c), low2 = hn::Min(b, d), high2 = hn::Max(b, d);
    const auto positive = hn::Or(hn::SaturatedSub(low1, high2), hn::SaturatedSub(low2, high1));
    const auto negative = hn::Min(hn::SaturatedSub(high2, low1), hn::SaturatedSub(high1, low2));
    const auto add = widen(d16, positive), less = widen(d16, negative);
    even = hn::Add(even, hn::Sub(add.even, less.even));
    odd = hn::Add(odd, hn::Sub(add.odd, less.odd));
    if constexpr (kMeanTerm) {
      for (const auto& sample : {a, b, c, d}) {
        const auto wide = widen(d16, sample);
        circle_even = hn::Add(circle_even, wide.even);
        circle_odd = hn::Add(circle_odd, wide.odd);
      }
    }
  }
  even = hn::Add(even, even);
  odd = hn::Add(odd, odd);
  if constexpr (kMeanTerm) {
    auto cross_even = hn::Zero(d16), cross_odd = hn::Zero(d16);
    for (const std::ptrdiff_t n : {std::ptrdiff_t{0}, std::ptrdiff_t{1}, std::ptrdiff_t{-1}, stride, -stride}) {
      const auto wide = widen(d16, hn::LoadU(d8, p + n));
      cross_even = hn::Add(cross_even, wide.even);
      cross_odd = hn::Add(cross_odd, wide.odd);
    }
    // |5 circle - 16 cross| <= 20400 fits; x / 5 = (x * 52429) >> 18 for x < 2^16.
    const hn::RebindToUnsigned<decltype(d16)> du16;
    const auto term = [&](auto circle, auto cross) {
      const auto five = hn::Add(hn::ShiftLeft<2>(circle), circle);
      const auto size = hn::BitCast(du16, hn::Abs(hn::Sub(five, hn::ShiftLeft<4>(cross))));
      return hn::BitCast(d16, hn::ShiftRight<2>(hn::MulHigh(size, hn::Set(du16, 52429))));
    };
    even = hn::Sub(even, term(circle_even, cross_even));
    odd = hn::Sub(odd, term(circle_odd, cross_odd));
  }
  hn::StoreInterleaved2(even, odd, d16, out);
}

template <bool kMeanTerm>
HWY_INLINE void row(const std::uint8_t* HWY_RESTRICT p, const std::ptrdiff_t* HWY_RESTRICT at, std::ptrdiff_t stride,
                    int n, std::int16_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::uint8_t> wide;
  const hn::CappedTag<std::uint8_t, 16> narrow;
  const int wide_step = static_cast<int>(hn::Lanes(wide)), narrow_step = static_cast<int>(hn::Lanes(narrow));
  int i = 0;
  for (; i + wide_step <= n; i += wide_step) responses<kMeanTerm>(wide, p + i, at, stride, out + i);
  for (; i + narrow_step <= n; i += narrow_step) responses<kMeanTerm>(narrow, p + i, at, stride, out + i);
  // The rest overlaps what is done: the same numbers again.
  if (i < n) responses<kMeanTerm>(narrow, p + n - narrow_step, at, stride, out + n - narrow_step);
}

void ResponseRow(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  constexpr int kLeast = 16;  // the narrowest vector
  if (u1 - u0 < kLeast) return scalar::response_row(image, v, u0, u1, options, out);
  const auto at = sample_distances(options.radius, image.stride_bytes);
  if (options.mean_term)
    row<true>(image.row(v) + u0, at.data(), image.stride_bytes, u1 - u0, out);
  else
    row<false>(image.row(v) + u0, at.data(), image.stride_bytes, u1 - u0, out);
}

int RowMaxima(const std::int16_t* HWY_RESTRICT above, const std::int16_t* HWY_RESTRICT here,
              const std::int16_t* HWY_RESTRICT below, int n, std::int16_t threshold, std::int32_t* HWY_RESTRICT at) {
  const hn::ScalableTag<std::int16_t> d;
  const int step = static_cast<int>(hn::Lanes(d));
  const auto limit = hn::Set(d, threshold);
  int count = 0, i = 1;
  for (; i + step + 1 <= n; i += step) {
    const auto r = hn::LoadU(d, here + i);
    const auto strong = hn::Gt(r, limit);
    if (hn::AllFalse(d, strong)) continue;
    // Greater than all that come before in reading order, not less than all that come after.
    const auto before = hn::Max(hn::Max(hn::LoadU(d, above + i - 1), hn::LoadU(d, above + i)),
                                hn::Max(hn::LoadU(d, above + i + 1), hn::LoadU(d, here + i - 1)));
    const auto after = hn::Max(hn::Max(hn::LoadU(d, below + i - 1), hn::LoadU(d, below + i)),
                               hn::Max(hn::LoadU(d, below + i + 1), hn::LoadU(d, here + i + 1)));
    const auto maximum = hn::AndNot(hn::Lt(r, after), hn::And(strong, hn::Gt(r, before)));
    if (hn::AllFalse(d, maximum)) continue;
    HWY_ALIGN std::int16_t flag[hn::MaxLanes(d)];
    hn::Store(hn::VecFromMask(d, maximum), d, flag);
    for (int k = 0; k < step; ++k)
      if (flag[k] != 0) at[count++] = i + k;
  }
  if (i + 1 < n) {
    const int rest = scalar::row_maxima(above + i - 1, here + i - 1, below + i - 1, n - i + 1, threshold, at + count);
    for (int k = 0; k < rest; ++k) at[count + k] += i - 1;
    count += rest;
  }
  return count;
}

template <bool kMeanTerm>
HWY_INLINE void window_rows(const GrayView& image, int first, const ResponseOptions& options, int columns,
                            ResponseWindow& window) {
  const hn::CappedTag<std::uint8_t, 16> d;
  const hn::CappedTag<std::int16_t, 8> d16;
  const auto at = sample_distances(options.radius, image.stride_bytes);
  const int skipped = window.u0 - first;
  HWY_ALIGN std::int16_t whole[2 * ResponseWindow::kStride];
  const auto nothing = hn::Set(d16, -32768);
  for (int i = 0; i < window.side; ++i) {
    const std::uint8_t* p = image.row(window.v0 + i) + first;
    for (int j = 0; j < columns; j += 16) responses<kMeanTerm>(d, p + j, at.data(), image.stride_bytes, whole + j);
    std::int16_t* row = window.at.data() + i * ResponseWindow::kStride;
    for (int j = 0; j < ResponseWindow::kStride; j += 8)
      hn::Store(hn::LoadU(d16, whole + skipped + j), d16, row + j);
    for (int j = window.side / 8 * 8; j < ResponseWindow::kStride; j += 8) {
      const auto inside = hn::FirstN(d16, static_cast<std::size_t>(std::max(window.side - j, 0)));
      hn::Store(hn::IfThenElse(inside, hn::Load(d16, row + j), nothing), d16, row + j);
    }
  }
}

void ResponseWindowOf(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options,
                      ResponseWindow& window) {
  const int columns = (side + 15) / 16 * 16;
  const int first = std::min(u0, image.width - options.radius - columns);
  if (first < options.radius) return scalar::response_window(image, u0, v0, side, options, window);
  window.u0 = u0;
  window.v0 = v0;
  window.side = side;
  if (options.mean_term)
    window_rows<true>(image, first, options, columns, window);
  else
    window_rows<false>(image, first, options, columns, window);
}

// Whole rows are skipped eight pixels at a time; few are left to look at one by one.
HWY_INLINE bool has_another(const ResponseWindow& window, const WindowPeak& peak, std::int16_t least) {
  constexpr int kPlateau = 4;
  const hn::CappedTag<std::int16_t, 8> d;
  const auto limit = hn::Set(d, static_cast<std::int16_t>(least - 1));
  for (int i = 1; i + 1 < window.side; ++i)
    for (int j = 0; j < window.side; j += 8) {
      const auto strong = hn::Gt(hn::Load(d, window.row(i) + j), limit);
      if (hn::AllFalse(d, strong)) continue;
      for (int k = std::max(j, 1); k < std::min(j + 8, window.side - 1); ++k) {
        const std::int16_t* at = window.row(i) + k;
        if (at[0] < least || std::max(std::abs(i - peak.row), std::abs(k - peak.column)) <= kPlateau) continue;
        if (at[0] >= at[-1] && at[0] >= at[1] && at[0] >= at[-ResponseWindow::kStride] &&
            at[0] >= at[ResponseWindow::kStride])
          return true;
      }
    }
  return false;
}

WindowPeak WindowPeakOf(const ResponseWindow& window, std::int16_t threshold) {
  const hn::CappedTag<std::int16_t, 8> d;
  auto most = hn::Set(d, -32768);
  for (int i = 0; i < window.side; ++i)
    for (int j = 0; j < window.side; j += 8) most = hn::Max(most, hn::Load(d, window.row(i) + j));
  HWY_ALIGN std::int16_t lane[8];
  hn::Store(most, d, lane);
  WindowPeak peak;
  peak.response = *std::max_element(lane, lane + 8);
  const auto best = hn::Set(d, peak.response);
  bool placed = false;
  for (int i = 0; i < window.side && !placed; ++i)
    for (int j = 0; j < window.side && !placed; j += 8) {
      const auto first = hn::FindFirstTrue(d, hn::Eq(hn::Load(d, window.row(i) + j), best));
      if (first < 0) continue;
      peak.row = i;
      peak.column = j + static_cast<int>(first);
      placed = true;
    }
  if (peak.response <= threshold) return peak;
  const int least = std::max<int>(threshold + 1, (peak.response + 1) / 2);
  peak.another = has_another(window, peak, static_cast<std::int16_t>(least));
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
HWY_EXPORT(RowMaxima);
HWY_EXPORT(ResponseWindowOf);
HWY_EXPORT(WindowPeakOf);
}  // namespace

void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(ResponseRow)(image, v, u0, u1, options, out);
}

int row_maxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n,
               std::int16_t threshold, std::int32_t* at) {
  return HWY_DYNAMIC_DISPATCH(RowMaxima)(above, here, below, n, threshold, at);
}

void response_window(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options,
                     ResponseWindow& window) {
  HWY_DYNAMIC_DISPATCH(ResponseWindowOf)(image, u0, v0, side, options, window);
}

WindowPeak window_peak(const ResponseWindow& window, std::int16_t threshold) {
  return HWY_DYNAMIC_DISPATCH(WindowPeakOf)(window, threshold);
}

}  // namespace srd::dsp
#endif
