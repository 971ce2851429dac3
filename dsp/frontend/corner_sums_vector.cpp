// SPDX-License-Identifier: Apache-2.0
// The sums of the corner fit, one source for every vector unit; equal to the scalar definition bit for bit.
#include <algorithm>
#include <cstring>

#include "dsp/frontend/corner_sums.hpp"
#include "dsp/frontend/edge_profile.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dsp/frontend/corner_sums_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace srd::dsp {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // a machine without any of the vector units

void Sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums) {
  scalar::corner_sums(window, pixels, model, sums);
}

#else

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<std::int16_t, 16>;
using Wide = hn::RepartitionToWide<Tag>;
constexpr int kPart = 128;          // pixels whose products a 32-bit sum holds
constexpr int kSharpenedPart = 64;  // the same of a sharpened image, whose columns are larger
constexpr int kMaxSharpened = 5790;
constexpr int kColumns = CornerSums::kColumns;

struct Part {
  HWY_ALIGN std::int16_t column[kColumns][kPart];
};

// Each product stays within 16 bits: 8 px at 3547 for the least blur, the pixel's own.
HWY_INLINE hn::Vec<Tag> line(const Tag d, const CornerModel::Line& l, hn::Vec<Tag> du, hn::Vec<Tag> dv) {
  const auto sum = hn::SaturatedAdd(hn::Mul(du, hn::Set(d, l.x)), hn::Mul(dv, hn::Set(d, l.y)));
  return hn::SaturatedAdd(sum, hn::Set(d, l.at));
}

// The profile of both edges, looked up one by one: the one step that has no vector form on every unit.
HWY_INLINE void look_up(int shape, const std::uint16_t* HWY_RESTRICT cell, int n, std::int16_t* HWY_RESTRICT value) {
  const EdgeProfile::Value* HWY_RESTRICT table = EdgeProfile::table(shape).data();
  for (int k = 0; k < n; k += 8) {  // n is a multiple of 8
    const EdgeProfile::Value a = table[cell[k]], b = table[cell[k + 1]], c = table[cell[k + 2]], d = table[cell[k + 3]];
    const EdgeProfile::Value e = table[cell[k + 4]], f = table[cell[k + 5]], g = table[cell[k + 6]], h = table[cell[k + 7]];
    std::memcpy(value + 2 * k, &a, 4);
    std::memcpy(value + 2 * k + 2, &b, 4);
    std::memcpy(value + 2 * k + 4, &c, 4);
    std::memcpy(value + 2 * k + 6, &d, 4);
    std::memcpy(value + 2 * k + 8, &e, 4);
    std::memcpy(value + 2 * k + 10, &f, 4);
    std::memcpy(value + 2 * k + 12, &g, 4);
    std::memcpy(value + 2 * k + 14, &h, 4);
  }
}

// Both edges at n pixels: distances from them and what the profile has there.
struct Profiles {
  HWY_ALIGN std::int16_t distance[2][kPart];
  HWY_ALIGN std::int16_t value[2][2 * kPart];
};

HWY_INLINE void look_up_edges(const CornerWindow& window, int from, int n, const std::array<CornerModel::Line, 2>& across,
                              const std::array<std::uint8_t, 2>& shape, Profiles& profiles) {
  const Tag d;
  const hn::RebindToUnsigned<Tag> du16;
  const int step = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN std::uint16_t cell[2][kPart];
  const auto low = hn::Set(d, -EdgeProfile::kReachQ10), high = hn::Set(d, EdgeProfile::kReachQ10 - 1);
  for (int k = 0; k < n; k += step) {
    const auto du = hn::Load(d, window.du.data() + from + k), dv = hn::Load(d, window.dv.data() + from + k);
    for (int edge = 0; edge < 2; ++edge) {
      const auto s = hn::Min(hn::Max(line(d, across[static_cast<std::size_t>(edge)], du, dv), low), high);
      hn::Store(s, d, profiles.distance[edge] + k);
      hn::Store(hn::BitCast(du16, hn::ShiftRight<2>(hn::Sub(s, low))), du16, cell[edge] + k);
    }
  }
  look_up(shape[0], cell[0], n, profiles.value[0]);
  look_up(shape[1], cell[1], n, profiles.value[1]);
}

// Not a struct of vectors: its constructor would not be of this vector unit.
HWY_INLINE void bracket(const Profiles& profiles, int k, hn::Vec<Tag> rho, hn::Vec<Tag>& value, hn::Vec<Tag>& move1,
                        hn::Vec<Tag>& move2, hn::Vec<Tag>& blur) {
  const Tag d;
  hn::Vec<Tag> step1, slope1, step2, slope2;
  hn::LoadInterleaved2(d, profiles.value[0] + 2 * k, step1, slope1);
  hn::LoadInterleaved2(d, profiles.value[1] + 2 * k, step2, slope2);
  const auto s1 = hn::ShiftLeft<2>(hn::Load(d, profiles.distance[0] + k));
  const auto s2 = hn::ShiftLeft<2>(hn::Load(d, profiles.distance[1] + k));
  value = hn::SaturatedAdd(hn::MulFixedPoint15(step1, step2), hn::MulFixedPoint15(hn::MulFixedPoint15(slope1, slope2), rho));
  move1 = hn::MulFixedPoint15(slope1, step2);
  move2 = hn::MulFixedPoint15(step1, slope2);
  blur = hn::Add(hn::MulFixedPoint15(s1, move1), hn::MulFixedPoint15(s2, move2));
}

HWY_INLINE hn::Vec<Tag> times4(hn::Vec<Tag> x) {
  const auto twice = hn::SaturatedAdd(x, x);
  return hn::SaturatedAdd(twice, twice);
}

HWY_INLINE hn::Vec<Tag> sharpened(hn::Vec<Tag> x, hn::Vec<Tag> wider, hn::Vec<Tag> amount) {
  return hn::SaturatedAdd(x, hn::MulFixedPoint15(times4(hn::SaturatedSub(x, wider)), amount));
}

// Columns of the pixels from 'from', n of them, a multiple of the vector's length.
template <bool kSharpened>
HWY_INLINE void fill(const CornerWindow& window, const std::uint8_t* HWY_RESTRICT pixels, int from, int n,
                     const CornerModel& model, Part& part) {
  const Tag d;
  const hn::Rebind<std::uint8_t, Tag> d8;
  const int step = static_cast<int>(hn::Lanes(d));
  Profiles own, wide;
  look_up_edges(window, from, n, model.across, model.shape, own);
  if constexpr (kSharpened) look_up_edges(window, from, n, model.mask.across, model.mask.shape, wide);
  const auto quarter = hn::Set(d, 1 << 13), half = hn::Set(d, 1 << 14);
  const auto rho = hn::Set(d, model.rho_q15), mean = hn::Set(d, model.mean_q6), contrast = hn::Set(d, model.contrast_q8);
  const auto store = [&](hn::Vec<Tag> column, hn::Mask<Tag> cut_off, int which, int k) HWY_ATTR {
    if constexpr (kSharpened)
      column = hn::IfThenZeroElse(cut_off, hn::Min(hn::Max(column, hn::Set(d, -kMaxSharpened)), hn::Set(d, kMaxSharpened)));
    hn::Store(column, d, part.column[which] + k);
  };
  for (int k = 0; k < n; k += step) {
    hn::Vec<Tag> value, move1, move2, blur;
    bracket(own, k, rho, value, move1, move2, blur);
    if constexpr (kSharpened) {
      const auto amount = hn::Set(d, model.mask.amount_q13), narrower = hn::Set(d, model.mask.narrower_q15);
      hn::Vec<Tag> wide_value, wide_move1, wide_move2, wide_blur;
      bracket(wide, k, rho, wide_value, wide_move1, wide_move2, wide_blur);
      value = sharpened(value, wide_value, amount);
      move1 = sharpened(move1, hn::MulFixedPoint15(wide_move1, narrower), amount);
      move2 = sharpened(move2, hn::MulFixedPoint15(wide_move2, narrower), amount);
      blur = sharpened(blur, hn::MulFixedPoint15(hn::MulFixedPoint15(wide_blur, narrower), narrower), amount);
    }
    const auto du = hn::Load(d, window.du.data() + from + k), dv = hn::Load(d, window.dv.data() + from + k);
    const auto level = hn::ShiftLeft<6>(hn::PromoteTo(d, hn::LoadU(d8, pixels + from + k)));
    const auto residual = hn::SaturatedSub(hn::SaturatedSub(level, mean), hn::MulFixedPoint15(contrast, value));
    // Black and white cut the overshoot off: where the model goes beyond them, or nearly, such a pixel says nothing.
    auto cut_off = hn::Lt(residual, residual);
    if constexpr (kSharpened) {
      cut_off = hn::Or(hn::And(hn::Eq(level, hn::Set(d, 255 << 6)), hn::Lt(residual, hn::Set(d, CornerModel::kNearlyCutOffQ6))),
                       hn::And(hn::Eq(level, hn::Zero(d)), hn::Gt(residual, hn::Set(d, -CornerModel::kNearlyCutOffQ6))));
    }
    const auto bounded = hn::Min(hn::Max(hn::MulFixedPoint15(residual, half), hn::Set(d, -4080)), hn::Set(d, 4080));
    store(hn::Load(d, window.one.data() + from + k), cut_off, CornerSums::kMean, k);
    store(hn::MulFixedPoint15(value, quarter), cut_off, CornerSums::kContrast, k);
    store(blur, cut_off, CornerSums::kBlur, k);
    store(hn::MulFixedPoint15(line(d, model.along[0], du, dv), move1), cut_off, CornerSums::kTurn1, k);
    store(hn::MulFixedPoint15(line(d, model.along[1], du, dv), move2), cut_off, CornerSums::kTurn2, k);
    store(hn::MulFixedPoint15(move1, quarter), cut_off, CornerSums::kMove1, k);
    store(hn::MulFixedPoint15(move2, quarter), cut_off, CornerSums::kMove2, k);
    store(bounded, cut_off, CornerSums::kResidual, k);
  }
}

// Products of kFirst columns from kFrom on with themselves and all that follow.
template <int kFrom, int kFirst>
HWY_INLINE void multiply(const Part& part, int n, CornerSums& sums) {
  const Tag d;
  const Wide d32;
  const int step = static_cast<int>(hn::Lanes(d));
  constexpr int kOthers = kColumns - kFrom;
  hn::Vec<Wide> low[kFirst][kOthers], high[kFirst][kOthers];
  for (int i = 0; i < kFirst; ++i)
    for (int j = i; j < kOthers; ++j) low[i][j] = high[i][j] = hn::Zero(d32);
  for (int k = 0; k < n; k += step) {
    hn::Vec<Tag> column[kOthers];
    for (int j = 0; j < kOthers; ++j) column[j] = hn::Load(d, part.column[kFrom + j] + k);
    for (int i = 0; i < kFirst; ++i)
      for (int j = i; j < kOthers; ++j)
        low[i][j] = hn::ReorderWidenMulAccumulate(d32, column[i], column[j], low[i][j], high[i][j]);
  }
  for (int i = 0; i < kFirst; ++i)
    for (int j = i; j < kOthers; ++j)
      sums.product[static_cast<std::size_t>(kFrom + i)][static_cast<std::size_t>(kFrom + j)] +=
          hn::GetLane(hn::SumOfLanes(d32, hn::Add(low[i][j], high[i][j])));
}

void Sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums) {
  sums = {};
  const int step = static_cast<int>(hn::Lanes(Tag()));
  Part part;
  const bool is_sharpened = model.mask.amount_q13 != 0;
  const int most = is_sharpened ? kSharpenedPart : kPart;
  for (int from = 0; from < window.size; from += most) {
    const int pixels_here = std::min(most, window.size - from);
    const int n = (pixels_here + step - 1) / step * step;
    if (is_sharpened)
      fill<true>(window, pixels, from, n, model, part);
    else
      fill<false>(window, pixels, from, n, model, part);
    if (n > pixels_here) {  // what the last vector holds beyond the window counts nothing
      const Tag d;
      const auto inside = hn::FirstN(d, static_cast<std::size_t>(pixels_here + step - n));
      for (auto& column : part.column) {
        std::int16_t* const last = column + n - step;
        hn::Store(hn::IfThenElseZero(inside, hn::Load(d, last)), d, last);
      }
    }
    multiply<0, 2>(part, n, sums);
    multiply<2, 2>(part, n, sums);
    multiply<4, 4>(part, n, sums);
  }
}

#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace srd::dsp
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace srd::dsp {

namespace {
HWY_EXPORT(Sums);
}

void corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums) {
  HWY_DYNAMIC_DISPATCH(Sums)(window, pixels, model, sums);
}

}  // namespace srd::dsp
#endif
