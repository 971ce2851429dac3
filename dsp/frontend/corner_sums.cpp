// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_sums.hpp"

#include <algorithm>

#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {

namespace {

// Rows dv with dv mod 2 = parity; all of them with -1.
constexpr CornerWindow make_window(int half_window, int parity) {
  CornerWindow window;
  for (int dv = -half_window; dv <= half_window; ++dv) {
    if (parity >= 0 && (dv & 1) != parity) continue;
    for (int du = -half_window; du <= half_window; ++du) {
      const auto at = static_cast<std::size_t>(window.size++);
      window.du[at] = static_cast<std::int16_t>(du);
      window.dv[at] = static_cast<std::int16_t>(dv);
      window.one[at] = 1 << 11;
    }
  }
  return window;
}

using Windows = std::array<CornerWindow, kMaxHalfWindow - kMinHalfWindow + 1>;
constexpr Windows make_windows(int parity) {
  Windows windows;
  for (int w = kMinHalfWindow; w <= kMaxHalfWindow; ++w)
    windows[static_cast<std::size_t>(w - kMinHalfWindow)] = make_window(w, parity);
  return windows;
}

std::size_t place_of(int half_window) {
  return static_cast<std::size_t>(std::clamp(half_window, kMinHalfWindow, kMaxHalfWindow) - kMinHalfWindow);
}

constexpr std::int16_t saturate(int x) { return static_cast<std::int16_t>(std::clamp(x, -32768, 32767)); }

// a b / 2^15 to nearest, halves up: what vector units call a rounding multiply high.
constexpr std::int16_t multiply(int a, int b) { return static_cast<std::int16_t>((a * b + (1 << 14)) >> 15); }

// Column x of Q13 in Q11.
constexpr std::int16_t quarter(std::int16_t x) { return multiply(x, 1 << 13); }

std::int16_t on_line(const CornerModel::Line& line, int du, int dv) {
  return saturate(saturate(du * line.x + dv * line.y) + line.at);
}

std::int16_t distance(const CornerModel::Line& line, int du, int dv) {
  return std::clamp<std::int16_t>(on_line(line, du, dv), -EdgeProfile::kReachQ10, EdgeProfile::kReachQ10 - 1);
}

// The bracket B and its derivatives by the edges' moves and by the blur, Q13.
struct Bracket {
  std::int16_t value, move1, move2;
  std::int16_t blur;  // Q10
};

Bracket bracket(const std::array<CornerModel::Line, 2>& across, const std::array<std::uint8_t, 2>& shape, std::int16_t rho_q15,
                int du, int dv) {
  const std::int16_t s1 = distance(across[0], du, dv), s2 = distance(across[1], du, dv);
  const EdgeProfile::Value p1 = EdgeProfile::table(shape[0])[static_cast<std::size_t>(EdgeProfile::cell(s1))];
  const EdgeProfile::Value p2 = EdgeProfile::table(shape[1])[static_cast<std::size_t>(EdgeProfile::cell(s2))];
  // Q14 times Q14 is Q13; times rho stays.
  Bracket b;
  b.value = saturate(multiply(p1.step, p2.step) + multiply(multiply(p1.slope, p2.slope), rho_q15));
  b.move1 = multiply(p1.slope, p2.step);
  b.move2 = multiply(p1.step, p2.slope);
  b.blur = static_cast<std::int16_t>(multiply(4 * s1, b.move1) + multiply(4 * s2, b.move2));
  return b;
}

constexpr std::int16_t kMaxSharpened = 5790;

// x + a (x - wider), cut off where a column ends; times 4 within 16 bits as long as the two differ by less than the contrast.
std::int16_t sharpened(int x, int wider, std::int16_t amount_q13) {
  return saturate(x + multiply(saturate(4 * saturate(x - wider)), amount_q13));
}

std::int16_t cut(std::int16_t column) { return std::clamp<std::int16_t>(column, -kMaxSharpened, kMaxSharpened); }

using Columns = std::array<std::int32_t, CornerSums::kColumns>;

// A pixel's columns with this bracket. False: black and white cut the overshoot off. Where the model goes beyond them, or nearly,
// such a pixel says nothing. Only beyond would choose pixels by their noise.
bool columns_of(const CornerModel& model, Bracket here, int du, int dv, int pixel, Columns& column) {
  const std::int16_t amount = model.mask.amount_q13;
  if (amount != 0) {
    const std::int16_t narrower = model.mask.narrower_q15;
    const Bracket wider = bracket(model.mask.across, model.mask.shape, model.rho_q15, du, dv);
    here.value = sharpened(here.value, wider.value, amount);
    here.move1 = sharpened(here.move1, multiply(wider.move1, narrower), amount);
    here.move2 = sharpened(here.move2, multiply(wider.move2, narrower), amount);
    // The wider blur grows by blur / wider of what the blur grows.
    here.blur = sharpened(here.blur, multiply(multiply(wider.blur, narrower), narrower), amount);
  }
  const std::int16_t residual_q6 = saturate(saturate((pixel << 6) - model.mean_q6) - multiply(model.contrast_q8, here.value));
  if (amount != 0 && ((pixel == 255 && residual_q6 < CornerModel::kNearlyCutOffQ6) ||
                      (pixel == 0 && residual_q6 > -CornerModel::kNearlyCutOffQ6)))
    return false;
  column[CornerSums::kMean] = 1 << 11;
  column[CornerSums::kContrast] = cut(quarter(here.value));
  column[CornerSums::kBlur] = cut(here.blur);
  column[CornerSums::kTurn1] = cut(multiply(on_line(model.along[0], du, dv), here.move1));
  column[CornerSums::kTurn2] = cut(multiply(on_line(model.along[1], du, dv), here.move2));
  column[CornerSums::kMove1] = cut(quarter(here.move1));
  column[CornerSums::kMove2] = cut(quarter(here.move2));
  column[CornerSums::kResidual] = std::clamp<int>(multiply(residual_q6, 1 << 14), -4080, 4080);
  return true;
}

void add(const Columns& column, CornerSums& sums) {
  for (std::size_t a = 0; a < CornerSums::kColumns; ++a)
    for (std::size_t b = a; b < CornerSums::kColumns; ++b) sums.product[a][b] += column[a] * column[b];
}

}  // namespace

const CornerWindow& corner_window(int half_window) {
  static constexpr Windows kWindows = make_windows(-1);
  return kWindows[place_of(half_window)];
}

const CornerWindow& corner_window_rows(int half_window, int parity) {
  static constexpr std::array<Windows, 2> kWindows{make_windows(0), make_windows(1)};
  return kWindows[static_cast<std::size_t>(parity)][place_of(half_window)];
}

namespace scalar {

void corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums) {
  sums = {};
  for (int k = 0; k < window.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const int du = window.du[i], dv = window.dv[i];
    Columns column;
    if (columns_of(model, bracket(model.across, model.shape, model.rho_q15, du, dv), du, dv, pixels[i], column))
      add(column, sums);
  }
}

}  // namespace scalar

}  // namespace srd::dsp
