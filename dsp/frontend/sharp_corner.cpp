// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/sharp_corner.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dsp/core/integer_math.hpp"
#include "dsp/frontend/edge_profile.hpp"
#include "dsp/frontend/sharp_edge.hpp"

namespace srd::dsp {

namespace {

constexpr int kPixelParts = 4;  // of a pixel's side, where both edges cross it

// The bracket and its derivatives at a pixel, of the whole contrast: |levels| <= 1.2, turns <= 23 px. Q14.
enum Term : std::uint8_t { kValue, kBend, kTurn1, kTurn2, kMove1, kMove2, kTerms };
using TermLevels = std::array<std::int32_t, kTerms>;

// How far from a pixel the unsharp mask still takes in others, in px, and what it gives to them: Q14, their sum with both sides
// is 1.
struct MaskKernel {
  static constexpr int kMostReach = 14;
  int reach = 0;
  std::array<std::int32_t, kMostReach + 1> weight{1 << 14};
};

MaskKernel kernel_of(const Sharpening& sharpening) {
  MaskKernel kernel;
  if (sharpening.amount_q12 <= 0) return kernel;
  const std::int64_t radius = std::clamp<std::int64_t>(sharpening.radius_q12, 1024, 4 * 4096);
  // 3.5 deviations hold all but 1/2000.
  kernel.reach = static_cast<int>(std::min<std::int64_t>((7 * radius / 2 + 4095) >> 12, MaskKernel::kMostReach));
  std::array<std::int64_t, MaskKernel::kMostReach + 1> bell{};
  std::int64_t sum = 0;
  for (int k = 0; k <= kernel.reach; ++k) {
    const std::int64_t s_q10 = (std::int64_t{k} << 22) / radius;
    const auto at = static_cast<std::size_t>(k);
    bell[at] = s_q10 >= EdgeProfile::kReachQ10
                   ? 0
                   : EdgeProfile::table(0)[static_cast<std::size_t>(EdgeProfile::cell(static_cast<int>(s_q10)))].slope;
    sum += (k == 0 ? 1 : 2) * bell[at];
  }
  std::int32_t rest = 1 << 14;
  for (int k = 1; k <= kernel.reach; ++k) {
    const auto at = static_cast<std::size_t>(k);
    kernel.weight[at] = static_cast<std::int32_t>(divide_rounded(bell[at] << 14, sum));
    rest -= 2 * kernel.weight[at];
  }
  kernel.weight[0] = rest;
  return kernel;
}

// The model without the mask, pixel by pixel.
class Unmasked {
 public:
  explicit Unmasked(const SharpCorner& corner)
      : corner_(corner),
        whole_{SharpEdge(corner.n1.x, corner.n1.y, corner.blur_q12, 1),
               SharpEdge(corner.n2.x, corner.n2.y, corner.blur_q12, 1)},
        part_{SharpEdge(corner.n1.x, corner.n1.y, corner.blur_q12, kPixelParts),
              SharpEdge(corner.n2.x, corner.n2.y, corner.blur_q12, kPixelParts)},
        rho_(dot(corner.n1, corner.n2)) {
    // The pixel's own variance is 1/12, a part's that over the square of the parts.
    const std::int64_t variance = corner.blur_q12 * corner.blur_q12, own = (std::int64_t{1} << 24) / 12;
    part_rho_ = rho_ * (variance - own + own / (kPixelParts * kPixelParts)) / variance;
  }

  [[nodiscard]] TermLevels at(int du, int dv) const {
    const std::int64_t x = (std::int64_t{du} << 16) - corner_.x, y = (std::int64_t{dv} << 16) - corner_.y;
    const std::int64_t across1 = (corner_.n1.x * x + corner_.n1.y * y) >> 14;
    const std::int64_t across2 = (corner_.n2.x * x + corner_.n2.y * y) >> 14;
    const std::int64_t along1 = (corner_.n1.x * y - corner_.n1.y * x) >> 14;
    const std::int64_t along2 = (corner_.n2.x * y - corner_.n2.y * x) >> 14;
    // Farther from the corner along either edge, the other edge is not in the pixel, and the mean of the product is that of means.
    constexpr std::int64_t kNear = 1 << 16;
    TermLevels levels = std::abs(along1) <= kNear && std::abs(along2) <= kNear
                            ? of_parts(across1, across2)
                            : product(whole_[0].at(across1), whole_[1].at(across2), rho_);
    levels[kTurn1] = static_cast<std::int32_t>((along1 * levels[kMove1]) >> 16);
    levels[kTurn2] = static_cast<std::int32_t>((along2 * levels[kMove2]) >> 16);
    return levels;
  }

 private:
  static std::int64_t dot(const Direction& a, const Direction& b) {
    return (std::int64_t{a.x} * b.x + std::int64_t{a.y} * b.y) >> 14;
  }
  static TermLevels product(const SharpEdge::Value& a, const SharpEdge::Value& b, std::int64_t rho) {
    const auto times = [](std::int64_t p, std::int64_t q) { return static_cast<std::int32_t>((p * q + (1 << 13)) >> 14); };
    TermLevels levels{};
    levels[kValue] = times(a.step, b.step) + static_cast<std::int32_t>((times(a.slope, b.slope) * rho) >> 14);
    levels[kBend] = -times(a.bend, b.step) - times(a.step, b.bend);
    levels[kMove1] = times(a.slope, b.step);
    levels[kMove2] = times(a.step, b.slope);
    return levels;
  }
  [[nodiscard]] TermLevels of_parts(std::int64_t across1, std::int64_t across2) const {
    TermLevels sum{};
    for (int j = 1 - kPixelParts; j < kPixelParts; j += 2)
      for (int i = 1 - kPixelParts; i < kPixelParts; i += 2) {
        // Half a part in Q16 px over the normal's Q14.
        const std::int64_t step1 = (std::int64_t{corner_.n1.x} * i + std::int64_t{corner_.n1.y} * j) * 2 / kPixelParts;
        const std::int64_t step2 = (std::int64_t{corner_.n2.x} * i + std::int64_t{corner_.n2.y} * j) * 2 / kPixelParts;
        const TermLevels part = product(part_[0].at(across1 + step1), part_[1].at(across2 + step2), part_rho_);
        for (std::size_t k = 0; k < kTerms; ++k) sum[k] += part[k];
      }
    for (std::int32_t& level : sum) level /= kPixelParts * kPixelParts;
    return sum;
  }

  const SharpCorner& corner_;
  std::array<SharpEdge, 2> whole_, part_;
  std::int64_t rho_, part_rho_ = 0;
};

// The window's pixels and, round them, those that the mask takes in.
constexpr int kMostSide = 2 * (kMaxHalfWindow + MaskKernel::kMostReach) + 1;
using TermPlane = std::array<std::int32_t, static_cast<std::size_t>(kMostSide) * kMostSide>;

}  // namespace

void sharp_corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const SharpCorner& corner, CornerSums& sums) {
  sums = {};
  const Unmasked model(corner);
  const MaskKernel kernel = kernel_of(corner.sharpening);
  const std::int64_t amount = std::clamp(corner.sharpening.amount_q12, 0, Sharpening::kMostAmountQ12);
  const int half = std::abs(window.du[0]), side = 2 * half + 1;
  const int reach = kernel.reach, outer = half + reach, rows = 2 * outer + 1;
  std::array<std::array<std::int32_t, CornerWindow::kRoom>, kTerms> masked;
  const auto place = [](int row, int column, int width) { return static_cast<std::size_t>(row * width + column); };
  if (amount == 0) {
    for (int k = 0; k < window.size; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const TermLevels here = model.at(window.du[i], window.dv[i]);
      for (std::size_t term = 0; term < kTerms; ++term) masked[term][i] = here[term];
    }
  } else {
    std::array<TermPlane, kTerms> sharp;
    for (int v = 0; v < rows; ++v)
      for (int u = 0; u < rows; ++u) {
        const TermLevels here = model.at(u - outer, v - outer);
        for (std::size_t term = 0; term < kTerms; ++term) sharp[term][place(v, u, rows)] = here[term];
      }
    TermPlane across;
    for (std::size_t term = 0; term < kTerms; ++term) {
      // Q14 by Q14; |turn| <= 2^19: in 64 bits.
      for (int v = 0; v < rows; ++v)
        for (int u = 0; u < side; ++u) {
          const std::int32_t* at = &sharp[term][place(v, u + reach, rows)];
          std::int64_t sum = std::int64_t{kernel.weight[0]} * at[0] + (1 << 13);
          for (int k = 1; k <= reach; ++k)
            sum += std::int64_t{kernel.weight[static_cast<std::size_t>(k)]} * (*(at - k) + at[k]);
          across[place(v, u, side)] = static_cast<std::int32_t>(sum >> 14);
        }
      for (int k = 0; k < window.size; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int u = window.du[i] + half, v = window.dv[i] + outer;
        std::int64_t sum = std::int64_t{kernel.weight[0]} * across[place(v, u, side)] + (1 << 13);
        for (int w = 1; w <= reach; ++w)
          sum += std::int64_t{kernel.weight[static_cast<std::size_t>(w)]} *
                 (across[place(v - w, u, side)] + across[place(v + w, u, side)]);
        const std::int64_t level = sharp[term][place(v, u + reach, rows)];
        masked[term][i] = static_cast<std::int32_t>(level + ((amount * (level - (sum >> 14))) >> 12));
      }
    }
  }
  for (int k = 0; k < window.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto cut = [&](Term term, int shift) {
      constexpr std::int32_t kMost = 5790;
      return std::int64_t{std::clamp((masked[term][i] + (1 << (shift - 1))) >> shift, -kMost, kMost)};
    };
    // Q8 of contrast by Q14.
    const std::int64_t residual_q6 =
        ((pixels[i] << 6) - corner.mean_q6) - ((std::int64_t{corner.contrast_q8} * masked[kValue][i] + (1 << 15)) >> 16);
    if (amount != 0 && ((pixels[i] == 255 && residual_q6 < CornerModel::kNearlyCutOffQ6) ||
                        (pixels[i] == 0 && residual_q6 > -CornerModel::kNearlyCutOffQ6)))
      continue;
    const std::array<std::int64_t, CornerSums::kColumns> column{
        1 << 11,        cut(kValue, 3), cut(kBend, 4),  cut(kTurn1, 6),
        cut(kTurn2, 6), cut(kMove1, 3), cut(kMove2, 3), std::clamp<std::int64_t>((residual_q6 + 1) >> 1, -4080, 4080)};
    for (std::size_t a = 0; a < CornerSums::kColumns; ++a)
      for (std::size_t b = a; b < CornerSums::kColumns; ++b) sums.product[a][b] += column[a] * column[b];
  }
}

}  // namespace srd::dsp
