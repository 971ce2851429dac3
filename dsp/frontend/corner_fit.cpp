// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_fit.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "dsp/core/fixed_ldl.hpp"
#include "dsp/frontend/corner_sums.hpp"
#include "dsp/frontend/edge_profile.hpp"
#include "dsp/frontend/sharp_corner.hpp"

namespace srd::dsp {

namespace {

using Ldl = FixedLdl<CornerSums::kColumns - 1>;

constexpr std::int64_t kMinBlurQ12 = 1183, kMaxBlurQ12 = 4096 * 6;  // Q12 px; the least is the pixel's own, sqrt(1/12)
constexpr std::int64_t kSmoothBlur = 4096 * 45 / 100;
constexpr std::int64_t kWished = (1 << 16) / 8;  // Q16 px: what steps that far to and fro is no corner
// Q16 grey levels: 0 to 255, half of that, and what noise may add. Beyond them residuals are cut off and look small.
constexpr std::int64_t kMinMean = -(16 << 16), kMaxMean = 271 << 16, kMaxContrast = 144 << 16;
constexpr std::int64_t kMaxMove = 1 << 16, kMaxTurn = 1 << 12;  // of one step: 1 px, 1/4 rad

// The state of the iteration: position in Q16 px relative to the window's centre pixel.
struct State {
  std::int64_t x = 0, y = 0;
  Direction n1, n2;                             // Q14
  std::int64_t blur = 4096;                     // Q12 px
  std::int64_t mean = 128 << 16, contrast = 0;  // Q16 grey levels
};

std::int64_t clamp(std::int64_t x, std::int64_t limit) { return std::clamp(x, -limit, limit); }

std::int64_t dot_q14(const Direction& a, const Direction& b) {
  return (static_cast<std::int64_t>(a.x) * b.x + static_cast<std::int64_t>(a.y) * b.y) >> 14;
}

// n1 x n2, Q14: the sine of the angle between the edges.
std::int64_t cross_q14(const Direction& a, const Direction& b) {
  return (static_cast<std::int64_t>(a.x) * b.y - static_cast<std::int64_t>(a.y) * b.x) >> 14;
}

// Turned by a small angle (Q14 rad), its length brought back to 1 by one Newton step on 1/sqrt.
Direction turned(const Direction& n, std::int64_t angle) {
  const std::int64_t x = n.x - ((n.y * angle) >> 14), y = n.y + ((n.x * angle) >> 14);
  const std::int64_t stretch = (3 << 27) - ((x * x + y * y) >> 1);  // (3 - |n|^2) / 2, Q28
  return {static_cast<std::int32_t>(shift_rounded(x * stretch, 28)), static_cast<std::int32_t>(shift_rounded(y * stretch, 28))};
}

std::int16_t narrow(std::int64_t x) { return static_cast<std::int16_t>(clamp(x, 32767)); }

// Distances from an edge through the state's corner in units of this blur.
CornerModel::Line line_across(const State& state, const Direction& n, std::int64_t blur_q12) {
  const std::int64_t per_blur_q18 = (std::int64_t{1} << 30) / blur_q12;
  const std::int64_t offset_q16 = shift_rounded(n.x * state.x + n.y * state.y, 14);
  return {narrow(shift_rounded(n.x * per_blur_q18, 22)), narrow(shift_rounded(n.y * per_blur_q18, 22)),
          narrow(-shift_rounded(offset_q16 * per_blur_q18, 24))};
}

CornerModel::Line line_along(const State& state, const Direction& n) {
  return {narrow(shift_rounded(-n.y, 4)), narrow(shift_rounded(n.x, 4)), narrow(-((-n.y * state.x + n.x * state.y) >> 20))};
}

CornerModel::Mask mask_of(const State& state, const Sharpening& sharpening) {
  CornerModel::Mask mask;
  mask.amount_q13 = static_cast<std::int16_t>(std::clamp(2 * sharpening.amount_q12, 0, int{CornerModel::kMostAmountQ13}));
  if (mask.amount_q13 == 0) return mask;
  const std::int64_t radius = std::clamp<std::int64_t>(sharpening.radius_q12, 1024, kMaxBlurQ12);
  const std::int64_t wider = isqrt(static_cast<std::uint64_t>(state.blur * state.blur + radius * radius));
  mask.narrower_q15 = narrow((state.blur << 15) / wider);
  mask.across = {line_across(state, state.n1, wider), line_across(state, state.n2, wider)};
  mask.shape = {static_cast<std::uint8_t>(EdgeProfile::shape_of(state.n1.x, state.n1.y, wider)),
                static_cast<std::uint8_t>(EdgeProfile::shape_of(state.n2.x, state.n2.y, wider))};
  return mask;
}

CornerModel model_of(const State& state, const Sharpening& sharpening) {
  CornerModel model;
  model.across = {line_across(state, state.n1, state.blur), line_across(state, state.n2, state.blur)};
  model.along = {line_along(state, state.n1), line_along(state, state.n2)};
  model.shape = {static_cast<std::uint8_t>(EdgeProfile::shape_of(state.n1.x, state.n1.y, state.blur)),
                 static_cast<std::uint8_t>(EdgeProfile::shape_of(state.n2.x, state.n2.y, state.blur))};
  model.mask = mask_of(state, sharpening);
  model.rho_q15 = narrow(2 * dot_q14(state.n1, state.n2));
  model.mean_q6 = narrow(shift_rounded(state.mean, 10));
  model.contrast_q8 = narrow(shift_rounded(state.contrast, 8));
  return model;
}

// Where sampling is coarser than the edges, or than what an unsharp mask makes of them.
bool is_sharp(const State& state, const Sharpening& sharpening) {
  return state.blur < (sharpening.amount_q12 > 0 ? SharpCorner::kMostBlurQ12 : kSmoothBlur);
}

void sums_of(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, const State& state,
             const Sharpening& sharpening, CornerSums& sums) {
  if (is_sharp(state, sharpening))
    sharp_corner_sums(window, pixels,
                      {state.x, state.y, state.n1, state.n2, state.blur, model.mean_q6, model.contrast_q8, sharpening}, sums);
  else
    corner_sums(window, pixels, model, sums);
}

// The window's pixels in its order. Whole 8-byte pieces where the row has them: what is too much, the next row overwrites.
void copy_window(const GrayView& image, int cu, int cv, int w, std::uint8_t* out) {
  const int side = 2 * w + 1, whole = (side + 7) / 8 * 8;
  const bool inside = cu - w + whole <= image.width;
  for (int dv = -w; dv <= w; ++dv, out += side) {
    const std::uint8_t* row = image.row(cv + dv) + cu - w;
    if (inside)
      for (int i = 0; i < side; i += 8) std::memcpy(out + i, row + i, 8);
    else
      std::memcpy(out, row, static_cast<std::size_t>(side));
  }
}

struct Step {
  std::int64_t move = 0;    // larger of the two axes, Q16 px
  std::int64_t wished = 0;  // the same before it was halved
  std::int64_t turn = 0;    // larger of the two, Q14 rad
  std::int64_t widen = 0;   // relative, Q14
};

// Where edges lie along pixels, one column of pixels sees them, and shows a blur and a move alike: Levenberg's damping of the
// blur alone keeps the step determined, and where they can be told apart it is some 1/200 of what the window knows. A fit that
// steps to and fro is tried with the blur that it has.
std::int64_t blur_damping(int halvings) {
  constexpr std::int64_t kDamping = std::int64_t{1} << 16;
  return halvings == 0 ? kDamping : kDamping << 6;
}

// One Gauss-Newton step from where the sums were taken. False: no corner that one would want to measure with.
bool advance(const Ldl& solver, const CornerModel& at, const CornerFitOptions& options, int halvings, State& state,
             Step& step) {
  state.mean = (static_cast<std::int64_t>(at.mean_q6) << 10) + solver.solution(CornerSums::kMean, 16 - 5 + 11);
  state.contrast = (static_cast<std::int64_t>(at.contrast_q8) << 8) + solver.solution(CornerSums::kContrast, 16 - 5 + 11);
  if (state.contrast < static_cast<std::int64_t>(options.min_contrast) << 16) return false;
  // The geometry's unknowns are in grey levels: times blur over contrast they are lengths and angles.
  const std::int64_t per_level_q28 = (state.blur << 32) / state.contrast;
  const auto in_px = [&](CornerSums::Column column, int shift) {
    const std::int64_t level_q16 = clamp(solver.solution(column, 16 - 5 + CornerSums::kQ[column]), 1 << 24);
    return shift_rounded(level_q16 * per_level_q28, shift);
  };
  const std::int64_t move1 = -in_px(CornerSums::kMove1, 28), move2 = -in_px(CornerSums::kMove2, 28);
  const std::int64_t turn1 = clamp(in_px(CornerSums::kTurn1, 30), kMaxTurn) >> halvings;
  const std::int64_t turn2 = clamp(in_px(CornerSums::kTurn2, 30), kMaxTurn) >> halvings;
  const std::int64_t det = cross_q14(state.n1, state.n2);
  const std::int64_t per_det_q28 = (std::int64_t{1} << 42) / det;
  const auto over_det = [&](std::int64_t a_q30) {
    return clamp(shift_rounded((a_q30 >> 14) * per_det_q28, 28), kMaxMove) >> halvings;
  };
  const std::int64_t limit = 8 * kMaxMove;
  const std::int64_t dx = over_det(state.n2.y * clamp(move1, limit) - state.n1.y * clamp(move2, limit));
  const std::int64_t dy = over_det(-state.n2.x * clamp(move1, limit) + state.n1.x * clamp(move2, limit));
  const std::int64_t wished = clamp(-in_px(CornerSums::kBlur, 32), state.blur / 3);
  // At the bound the wish to go beyond it never ends; what counts is what the bound lets through.
  const std::int64_t blur = std::clamp(state.blur + wished, kMinBlurQ12, kMaxBlurQ12), widen = blur - state.blur;
  state.x += dx;
  state.y += dy;
  state.n1 = turned(state.n1, turn1);
  state.n2 = turned(state.n2, turn2);
  step.move = std::max(std::abs(dx), std::abs(dy));
  step.wished = step.move << halvings;
  step.turn = std::max(std::abs(turn1), std::abs(turn2));
  step.widen = (std::abs(widen) << 14) / state.blur;
  state.blur = blur;
  return true;
}

// The step's own error: of third order in the move alone, since what is of second order is even about the corner and the
// move's columns are odd; of second order where the columns themselves were off by the blur's or the edges' change.
// Edges of a box have no third order, and what is cut off changes with each step: there the step must be small itself.
bool converged(const Step& step, std::int64_t enough) {
  constexpr std::int64_t kShape = (1 << 14) / 8;
  constexpr std::int64_t kProduct = std::int64_t{1} << (16 + 14 - 9);  // 1/512 px
  return step.wished <= kWished && step.move <= enough && step.widen <= kShape && step.turn <= kShape &&
         step.move * std::max(step.widen, step.turn) <= kProduct;
}

// Past these steps a fit of edges between sharp and smooth may go to and fro between pixels for ever.
int patience_of(const State& state) { return state.blur < kSmoothBlur ? 9 : 5; }

// The step that is small enough, Q16 px. Past the patience it doubles each time: what the fit has come to is as good as it gets.
std::int64_t enough_at(int iteration, const State& state, const Sharpening& sharpening) {
  const bool sharp = is_sharp(state, sharpening);
  if (!sharp && sharpening.amount_q12 <= 0) return kWished;
  const std::int64_t enough = (1 << 16) / (sharp ? 1024 : 256);
  return std::min(enough << std::clamp(iteration - patience_of(state), 0, 8), kWished);
}

// How often a step is halved.
int halvings_at(int iteration, const State& state) {
  if (state.blur >= 2 * kSmoothBlur || iteration < patience_of(state)) return 0;
  return 1 + (iteration - patience_of(state)) / 2;
}

// Standard deviation of a coordinate, Q12 px: the moves' covariance in blurs, turned to the image's axes.
std::int64_t deviation_q12(const Ldl& solver, const State& state, std::int64_t residual_q6) {
  const Ldl::Block block = solver.last_block(24 + 2 * 11);
  const std::int64_t rho = dot_q14(state.n1, state.n2);
  const std::int64_t det = std::abs(cross_q14(state.n1, state.n2));
  // trace(N^-1 C N^-T) = (C11 + C22 - 2 rho C12) / det^2 for unit normals; half of it an axis.
  const std::int64_t trace_q24 = block.first + block.second - ((2 * rho * block.cross) >> 14);
  const std::int64_t root_q16 =
      isqrt(static_cast<std::uint64_t>(clamp(std::max<std::int64_t>(trace_q24, 0), std::int64_t{1} << 50)) << 7);
  const std::int64_t per_level_q28 = (state.blur << 32) / state.contrast;
  const std::int64_t spread_q20 = (residual_q6 * per_level_q28) >> 14;
  return shift_rounded(spread_q20 * clamp(root_q16, 1 << 22) / det, 10);
}

// A soft edge wants a window that sees both its sides: 2.8 blurs each way, at most 8/5 of the window that is asked for.
int window_for(const GrayView& image, int cu, int cv, std::int32_t blur_q12, int half_window) {
  const int least = std::clamp(half_window, kMinHalfWindow, kMaxHalfWindow);
  const int most = std::min(least * 8 / 5, kMaxHalfWindow);
  const int wanted = (std::min(blur_q12, 16 * 4096) * 14 / 5 + 4095) >> 12;
  const int w = std::clamp(wanted, least, most);
  return image.contains(cu, cv, w) ? w : least;
}

// From the move columns: what moves the model on even rows to one side and on odd rows to the other. The rows' own noise is what
// neither explains.
float rows_apart(const GrayView& image, int cu, int cv, int w, const State& state, const Sharpening& sharpening) {
  const CornerModel model = model_of(state, sharpening);
  const int side = 2 * w + 1;
  std::array<CornerSums, 2> sums;
  for (int parity = 0; parity < 2; ++parity) {
    std::array<std::uint8_t, CornerWindow::kRoom> pixels;
    std::uint8_t* out = pixels.data();
    for (int dv = -w; dv <= w; ++dv) {
      if ((dv & 1) != parity) continue;
      std::memcpy(out, image.row(cv + dv) + cu - w, static_cast<std::size_t>(side));
      out += side;
    }
    sums_of(corner_window_rows(w, parity), pixels.data(), model, state, sharpening, sums[static_cast<std::size_t>(parity)]);
  }
  const auto both = [&](CornerSums::Column a, CornerSums::Column b) {
    return static_cast<double>(sums[0].product[a][b] + sums[1].product[a][b]);
  };
  const auto between = [&](CornerSums::Column a, CornerSums::Column b) {
    return static_cast<double>(sums[0].product[a][b] - sums[1].product[a][b]);
  };
  constexpr auto k1 = CornerSums::kMove1, k2 = CornerSums::kMove2, kR = CornerSums::kResidual;
  const double m11 = both(k1, k1), m12 = both(k1, k2), m22 = both(k2, k2), g1 = between(k1, kR), g2 = between(k2, kR);
  const double det = m11 * m22 - m12 * m12;
  if (!(det > 0)) return 0;
  const double explained = (m22 * g1 * g1 - 2 * m12 * g1 * g2 + m11 * g2 * g2) / det;
  const double rest = (both(kR, kR) - explained) / (side * side - CornerSums::kColumns - 1);
  // Rounding alone leaves 1/12 of a grey level's square.
  const double least = (1 << (2 * CornerSums::kQ[kR])) / 12.0;
  return static_cast<float>(explained / std::max(rest, least));
}

}  // namespace

bool fit_corner(const GrayView& image, const CornerShape& start, const CornerFitOptions& options, CornerFit& fit) {
  const int cu = start.u.round(), cv = start.v.round();
  const int w = window_for(image, cu, cv, start.blur_q12, options.half_window);
  if (!image.contains(cu, cv, w)) return false;
  const CornerWindow& window = corner_window(w);
  std::array<std::uint8_t, CornerWindow::kRoom> pixels;
  copy_window(image, cu, cv, w, pixels.data());
  State state;
  state.x = (static_cast<std::int64_t>(start.u.raw()) << 4) - (static_cast<std::int64_t>(cu) << 16);
  state.y = (static_cast<std::int64_t>(start.v.raw()) << 4) - (static_cast<std::int64_t>(cv) << 16);
  state.n1 = start.n1;
  state.n2 = start.n2;
  state.blur = std::clamp<std::int64_t>(start.blur_q12, kMinBlurQ12, kMaxBlurQ12);

  const std::int64_t start_x = state.x, start_y = state.y;
  const std::int64_t max_travel = static_cast<std::int64_t>(options.max_travel_q12) << 4;
  CornerSums sums;
  Ldl solver;
  int iteration = 0;
  for (; iteration < options.max_iterations; ++iteration) {
    if (std::abs(cross_q14(state.n1, state.n2)) < (1 << 14) / 4) return false;  // less than 14 degrees between the edges
    const CornerModel model = model_of(state, options.sharpening);
    sums_of(window, pixels.data(), model, state, options.sharpening, sums);
    Step step;
    const int halvings = halvings_at(iteration, state);
    sums.product[CornerSums::kBlur][CornerSums::kBlur] += blur_damping(halvings);
    if (!solver.factor(sums.product)) return false;
    if (!advance(solver, model, options, halvings, state, step)) return false;
    if (std::abs(state.x - start_x) > max_travel || std::abs(state.y - start_y) > max_travel) return false;
    // The corner must stay well inside its window, or half the edges are not seen.
    if (std::abs(state.x) > ((w - 1) << 16) || std::abs(state.y) > ((w - 1) << 16)) return false;
    if (converged(step, enough_at(iteration, state, options.sharpening))) break;
  }
  if (iteration == options.max_iterations) return false;
  if (std::abs(cross_q14(state.n1, state.n2)) < (1 << 14) / 4) return false;
  // Strokes of letters, a pattern finer than the window: they fit as something wider and brighter than any corner is.
  if (state.blur >= kMaxBlurQ12 || state.contrast > kMaxContrast || state.mean < kMinMean || state.mean > kMaxMean)
    return false;

  // Of a sharpened image, pixels that were cut off at black and white do not count; overshoot fills half of a window.
  const std::int64_t pixels_used =
      sums.product[CornerSums::kMean][CornerSums::kMean] >> (2 * CornerSums::kQ[CornerSums::kMean]);
  if (3 * pixels_used < window.size) return false;
  const std::int64_t variance_q12 = solver.remainder(2) / (pixels_used - (CornerSums::kColumns - 1));
  const std::int64_t residual_q6 = isqrt(static_cast<std::uint64_t>(variance_q12));
  const std::int64_t contrast_q6 = state.contrast >> 10;
  if (residual_q6 * 100 > contrast_q6 * options.max_residual_percent) return false;

  fit.shape.u = Pixel::from_raw(static_cast<std::int32_t>((static_cast<std::int64_t>(cu) << 12) + shift_rounded(state.x, 4)));
  fit.shape.v = Pixel::from_raw(static_cast<std::int32_t>((static_cast<std::int64_t>(cv) << 12) + shift_rounded(state.y, 4)));
  fit.shape.n1 = state.n1;
  fit.shape.n2 = state.n2;
  fit.shape.blur_q12 = static_cast<std::int32_t>(state.blur);
  fit.corner.u = fit.shape.u;
  fit.corner.v = fit.shape.v;
  fit.corner.sigma_q12 = static_cast<std::uint32_t>(std::max<std::int64_t>(deviation_q12(solver, state, residual_q6), 1));
  fit.corner.mean = static_cast<std::uint8_t>(std::clamp<std::int64_t>(state.mean >> 16, 0, 255));
  fit.corner.contrast = static_cast<std::uint8_t>(std::clamp<std::int64_t>(state.contrast >> 16, 0, 255));
  fit.residual_q6 = static_cast<std::int32_t>(residual_q6);
  fit.iterations = iteration + 1;
  fit.rows_apart = options.compare_rows ? rows_apart(image, cu, cv, w, state, options.sharpening) : 0;
  return true;
}

}  // namespace srd::dsp
