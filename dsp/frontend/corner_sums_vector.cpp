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
constexpr int kPart = 128;  // pixels whose products a 32-bit sum holds
constexpr int kColumns = CornerSums::kColumns;

struct Part {
  HWY_ALIGN std::int16_t column[kColumns][kPart];
};

// Without the constant the sum stays within 16 bits: 11.4 px at 2844 for a blur of 0.36 px.
HWY_INLINE hn::Vec<Tag> line(const Tag d, const CornerModel::Line& l, hn::Vec<Tag> du, hn::Vec<Tag> dv) {
  const auto sum = hn::Add(hn::Mul(du, hn::Set(d, l.x)), hn::Mul(dv, hn::Set(d, l.y)));
  return hn::SaturatedAdd(sum, hn::Set(d, l.at));
}

// The profile of both edges, looked up one by one: the one step that has no vector form on every unit.
HWY_INLINE void look_up(const std::uint16_t* HWY_RESTRICT cell, int n, std::int16_t* HWY_RESTRICT value) {
  const EdgeProfile::Value* HWY_RESTRICT table = EdgeProfile::table().data();
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

// Columns of the pixels from 'from', n of them, a multiple of the vector's length.
HWY_INLINE void fill(const CornerWindow& window, const std::uint8_t* HWY_RESTRICT pixels, int from, int n,
                     const CornerModel& model, Part& part) {
  const Tag d;
  const hn::Rebind<std::uint8_t, Tag> d8;
  const hn::RebindToUnsigned<Tag> du16;
  const int step = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN std::uint16_t cell[2][kPart];
  HWY_ALIGN std::int16_t distance[2][kPart];
  HWY_ALIGN std::int16_t value[2][2 * kPart];
  const auto low = hn::Set(d, -EdgeProfile::kReachQ10), high = hn::Set(d, EdgeProfile::kReachQ10 - 1);
  for (int k = 0; k < n; k += step) {
    const auto du = hn::Load(d, window.du.data() + from + k), dv = hn::Load(d, window.dv.data() + from + k);
    for (int edge = 0; edge < 2; ++edge) {
      const auto s = hn::Min(hn::Max(line(d, model.across[static_cast<std::size_t>(edge)], du, dv), low), high);
      hn::Store(s, d, distance[edge] + k);
      hn::Store(hn::BitCast(du16, hn::ShiftRight<2>(hn::Sub(s, low))), du16, cell[edge] + k);
    }
  }
  look_up(cell[0], n, value[0]);
  look_up(cell[1], n, value[1]);
  const auto quarter = hn::Set(d, 1 << 13), half = hn::Set(d, 1 << 14);
  const auto rho = hn::Set(d, model.rho_q15), mean = hn::Set(d, model.mean_q6), contrast = hn::Set(d, model.contrast_q8);
  for (int k = 0; k < n; k += step) {
    hn::Vec<Tag> step1, slope1, step2, slope2;
    hn::LoadInterleaved2(d, value[0] + 2 * k, step1, slope1);
    hn::LoadInterleaved2(d, value[1] + 2 * k, step2, slope2);
    const auto du = hn::Load(d, window.du.data() + from + k), dv = hn::Load(d, window.dv.data() + from + k);
    const auto shape = hn::SaturatedAdd(hn::MulFixedPoint15(step1, step2),
                                        hn::MulFixedPoint15(hn::MulFixedPoint15(slope1, slope2), rho));
    const auto move1 = hn::MulFixedPoint15(slope1, step2), move2 = hn::MulFixedPoint15(step1, slope2);
    const auto level = hn::ShiftLeft<6>(hn::PromoteTo(d, hn::LoadU(d8, pixels + from + k)));
    const auto residual = hn::SaturatedSub(hn::SaturatedSub(level, mean), hn::MulFixedPoint15(contrast, shape));
    const auto bounded = hn::Min(hn::Max(hn::MulFixedPoint15(residual, half), hn::Set(d, -4080)), hn::Set(d, 4080));
    const auto s1 = hn::ShiftLeft<2>(hn::Load(d, distance[0] + k)), s2 = hn::ShiftLeft<2>(hn::Load(d, distance[1] + k));
    hn::Store(hn::Load(d, window.one.data() + from + k), d, part.column[CornerSums::kMean] + k);
    hn::Store(hn::MulFixedPoint15(shape, quarter), d, part.column[CornerSums::kContrast] + k);
    hn::Store(hn::Add(hn::MulFixedPoint15(s1, move1), hn::MulFixedPoint15(s2, move2)), d,
              part.column[CornerSums::kBlur] + k);
    hn::Store(hn::MulFixedPoint15(line(d, model.along[0], du, dv), move1), d, part.column[CornerSums::kTurn1] + k);
    hn::Store(hn::MulFixedPoint15(line(d, model.along[1], du, dv), move2), d, part.column[CornerSums::kTurn2] + k);
    hn::Store(hn::MulFixedPoint15(move1, quarter), d, part.column[CornerSums::kMove1] + k);
    hn::Store(hn::MulFixedPoint15(move2, quarter), d, part.column[CornerSums::kMove2] + k);
    hn::Store(bounded, d, part.column[CornerSums::kResidual] + k);
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
  for (int from = 0; from < window.size; from += kPart) {
    const int pixels_here = std::min(kPart, window.size - from);
    const int n = (pixels_here + step - 1) / step * step;
    fill(window, pixels, from, n, model, part);
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
