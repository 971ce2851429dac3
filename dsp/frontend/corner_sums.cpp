#include "dsp/frontend/corner_sums.hpp"

#include <algorithm>

#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {

namespace {

constexpr CornerWindow make_window(int half_window) {
  CornerWindow window;
  for (int dv = -half_window; dv <= half_window; ++dv)
    for (int du = -half_window; du <= half_window; ++du) {
      const auto at = static_cast<std::size_t>(window.size++);
      window.du[at] = static_cast<std::int16_t>(du);
      window.dv[at] = static_cast<std::int16_t>(dv);
      window.one[at] = 1 << 11;
    }
  return window;
}

constexpr std::int16_t saturate(int x) { return static_cast<std::int16_t>(std::clamp(x, -32768, 32767)); }

// a b / 2^15 to nearest, halves up: what vector units call a rounding multiply high.
constexpr std::int16_t multiply(int a, int b) { return static_cast<std::int16_t>((a * b + (1 << 14)) >> 15); }

// Column x of Q13 in Q11.
constexpr std::int16_t quarter(std::int16_t x) { return multiply(x, 1 << 13); }

std::int16_t distance(const CornerModel::Line& line, int du, int dv) {
  const std::int16_t s = saturate(du * line.x + dv * line.y + line.at);
  return std::clamp<std::int16_t>(s, -EdgeProfile::kReachQ10, EdgeProfile::kReachQ10 - 1);
}

}  // namespace

const CornerWindow& corner_window(int half_window) {
  static constexpr std::array<CornerWindow, kMostHalfWindow - kLeastHalfWindow + 1> kWindows{
      make_window(3), make_window(4), make_window(5), make_window(6), make_window(7), make_window(8)};
  return kWindows[static_cast<std::size_t>(std::clamp(half_window, kLeastHalfWindow, kMostHalfWindow) - kLeastHalfWindow)];
}

namespace scalar {

void corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums) {
  sums = {};
  const EdgeProfile::Table& table = EdgeProfile::table();
  for (int k = 0; k < window.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const int du = window.du[i], dv = window.dv[i];
    const std::int16_t s1 = distance(model.across[0], du, dv), s2 = distance(model.across[1], du, dv);
    const EdgeProfile::Value p1 = table[static_cast<std::size_t>(EdgeProfile::cell(s1))];
    const EdgeProfile::Value p2 = table[static_cast<std::size_t>(EdgeProfile::cell(s2))];
    // Q14 times Q14 is Q13; times rho stays.
    const std::int16_t shape =
        saturate(multiply(p1.step, p2.step) + multiply(multiply(p1.slope, p2.slope), model.rho_q15));
    const std::int16_t move1 = multiply(p1.slope, p2.step), move2 = multiply(p1.step, p2.slope);
    const auto along = [&](const CornerModel::Line& line) { return du * line.x + dv * line.y + line.at; };
    const std::int16_t residual_q6 =
        saturate(saturate((pixels[i] << 6) - model.mean_q6) - multiply(model.contrast_q8, shape));
    std::array<std::int32_t, CornerSums::kColumns> column;
    column[CornerSums::kMean] = window.one[i];
    column[CornerSums::kContrast] = quarter(shape);
    column[CornerSums::kBlur] = multiply(4 * s1, move1) + multiply(4 * s2, move2);
    column[CornerSums::kTurn1] = multiply(along(model.along[0]), move1);
    column[CornerSums::kTurn2] = multiply(along(model.along[1]), move2);
    column[CornerSums::kMove1] = quarter(move1);
    column[CornerSums::kMove2] = quarter(move2);
    column[CornerSums::kResidual] = std::clamp<int>(multiply(residual_q6, 1 << 14), -4080, 4080);
    for (std::size_t a = 0; a < CornerSums::kColumns; ++a)
      for (std::size_t b = a; b < CornerSums::kColumns; ++b) sums.product[a][b] += column[a] * column[b];
  }
}

}  // namespace scalar
}  // namespace srd::dsp
