#include "dsp/frontend/corner_fit.hpp"

#include <algorithm>
#include <array>

#include "dsp/core/integer_math.hpp"
#include "dsp/frontend/edge_profile.hpp"
#include "dsp/frontend/ring.hpp"

namespace srd::dsp {

namespace {

constexpr int kUnknowns = 7;
// Columns of the Jacobian, in Q12: move along n1, n2 (times -c/blur); turn of edge 1, 2 (times c/blur); m; c; blur.
enum Column { kMove1, kMove2, kTurn1, kTurn2, kMean, kContrast, kBlur };

constexpr std::int32_t kMinBlur = 4096 * 35 / 100, kMaxBlur = 4096 * 4;

bool normalise(Direction& d) {
  const std::int64_t x = d.x, y = d.y;
  const std::int64_t length = isqrt(static_cast<std::uint64_t>(x * x + y * y) << 12);  // Q6 above d's unit
  if (length == 0) return false;
  d.x = static_cast<std::int32_t>(divide_rounded(x << 20, length));
  d.y = static_cast<std::int32_t>(divide_rounded(y << 20, length));
  return true;
}

// The state of the iteration: q in Q16 px relative to the window's centre pixel, m and c in Q6 grey levels.
struct State {
  std::int64_t x = 0, y = 0;
  Direction n1, n2;
  std::int64_t blur = 4096;
  std::int64_t mean = 0, contrast = 0;
};

struct Normal {
  std::array<std::array<std::int64_t, kUnknowns>, kUnknowns> matrix{};
  std::array<std::int64_t, kUnknowns> right{};
  std::int64_t squares = 0;  // sum of residual^2, Q12
};

// Sums over the window. Ranges with w <= 8: columns |a| <= 12 * 2^12 < 2^16, residual < 2^15, 289 products < 2^41.
void accumulate(const GrayView& image, int cu, int cv, int w, const State& state, Normal& normal) {
  const std::int64_t rho_q14 =
      (static_cast<std::int64_t>(state.n1.x) * state.n2.x + static_cast<std::int64_t>(state.n1.y) * state.n2.y) >> 14;
  const std::int64_t inverse_blur_q12 = (std::int64_t{1} << 24) / state.blur;
  for (int dv = -w; dv <= w; ++dv) {
    const std::uint8_t* row = image.row(cv + dv) + cu;
    for (int du = -w; du <= w; ++du) {
      const std::int64_t x = (static_cast<std::int64_t>(du) << 16) - state.x;  // Q16
      const std::int64_t y = (static_cast<std::int64_t>(dv) << 16) - state.y;
      const std::int64_t across1 = (state.n1.x * x + state.n1.y * y) >> 14;  // Q16 px
      const std::int64_t across2 = (state.n2.x * x + state.n2.y * y) >> 14;
      // To nearest: flooring would move every corner by 1/512 of the blur.
      const std::int64_t s1 = shift_rounded(across1 * inverse_blur_q12, 20);  // Q8
      const std::int64_t s2 = shift_rounded(across2 * inverse_blur_q12, 20);
      const EdgeProfile::Value p1 = EdgeProfile::at(s1), p2 = EdgeProfile::at(s2);
      const std::int64_t product = (static_cast<std::int64_t>(p1.step) * p2.step) >> 14;
      const std::int64_t skew = (((static_cast<std::int64_t>(p1.slope) * p2.slope) >> 14) * rho_q14) >> 14;
      const std::int64_t shape = product + skew;  // Q14
      std::array<std::int64_t, kUnknowns> a;
      a[kMove1] = (static_cast<std::int64_t>(p1.slope) * p2.step) >> 16;  // Q12
      a[kMove2] = (static_cast<std::int64_t>(p1.step) * p2.slope) >> 16;
      const std::int64_t along1 = (-state.n1.y * x + state.n1.x * y) >> 14;  // Q16 px
      const std::int64_t along2 = (-state.n2.y * x + state.n2.x * y) >> 14;
      a[kTurn1] = (along1 * a[kMove1]) >> 16;
      a[kTurn2] = (along2 * a[kMove2]) >> 16;
      a[kMean] = 1 << 12;
      a[kContrast] = shape >> 2;
      a[kBlur] = (s1 * a[kMove1] + s2 * a[kMove2]) >> 8;
      const std::int64_t residual =
          (static_cast<std::int64_t>(row[du]) << 6) - (state.mean + ((state.contrast * shape) >> 14));
      for (int i = 0; i < kUnknowns; ++i) {
        for (int j = i; j < kUnknowns; ++j) normal.matrix[i][j] += a[i] * a[j];
        normal.right[i] += a[i] * residual;
      }
      normal.squares += residual * residual;
    }
  }
}

std::int64_t clamp(std::int64_t x, std::int64_t limit) { return std::clamp(x, -limit, limit); }

// det = n1 x n2, Q14: the sine of the angle between the edges.
std::int64_t cross_q14(const State& s) {
  return (static_cast<std::int64_t>(s.n1.x) * s.n2.y - static_cast<std::int64_t>(s.n1.y) * s.n2.x) >> 14;
}

// Levels of bright and dark from the window's first sums: least squares of m and c alone.
bool start_levels(const GrayView& image, int cu, int cv, int w, State& state) {
  state.mean = 0;
  state.contrast = 0;
  Normal normal;
  accumulate(image, cu, cv, w, state, normal);
  const std::int64_t n = normal.matrix[kMean][kMean], p = normal.matrix[kMean][kContrast];
  const std::int64_t pp = normal.matrix[kContrast][kContrast];
  FixedCholesky<2> solver;
  if (!solver.factor({{{n, p}, {0, pp}}})) return false;
  std::array<std::int64_t, 2> x;
  solver.solve({normal.right[kMean], normal.right[kContrast]}, 12, x);
  state.mean = x[0];
  state.contrast = x[1];
  return true;
}

}  // namespace

bool guess_shape(const GrayView& image, int u, int v, int radius, CornerShape& shape) {
  if (!image.contains(u, v, radius)) return false;
  const auto& offsets = ring(radius);
  std::array<int, 16> level;
  int sum = 0;
  for (std::size_t n = 0; n < 16; ++n) {
    level[n] = image.row(v + offsets[n].y)[u + offsets[n].x];
    sum += level[n];
  }
  for (int& l : level) l = 16 * l - sum;  // 16 (I - mean)
  // Where the sign changes between neighbours, by linear interpolation, Q8 px.
  struct Crossing {
    std::int64_t x, y;
  };
  std::array<Crossing, 4> crossing{};
  std::size_t count = 0;
  bool first_falls = false;
  for (std::size_t n = 0; n < 16; ++n) {
    const std::size_t next = (n + 1) % 16;
    if ((level[n] > 0) == (level[next] > 0)) continue;
    if (count == 4) return false;
    if (count == 0) first_falls = level[n] > 0;
    const std::int64_t weight = divide_rounded(static_cast<std::int64_t>(std::abs(level[n])) << 8,
                                               std::abs(level[n]) + std::abs(level[next]));
    crossing[count].x = (offsets[n].x << 8) + (offsets[next].x - offsets[n].x) * weight;
    crossing[count].y = (offsets[n].y << 8) + (offsets[next].y - offsets[n].y) * weight;
    ++count;
  }
  if (count != 4) return false;
  // Edge 1 joins crossings 0 and 2, edge 2 joins 1 and 3; the corner is where they meet.
  const std::int64_t d1x = crossing[2].x - crossing[0].x, d1y = crossing[2].y - crossing[0].y;
  const std::int64_t d2x = crossing[3].x - crossing[1].x, d2y = crossing[3].y - crossing[1].y;
  const std::int64_t det = d1x * d2y - d1y * d2x;
  if (det == 0) return false;
  const std::int64_t rx = crossing[1].x - crossing[0].x, ry = crossing[1].y - crossing[0].y;
  const std::int64_t t_q12 = ((rx * d2y - ry * d2x) << 12) / det;
  if (t_q12 < 0 || t_q12 > 4096) return false;
  shape.u = Pixel::from_raw((u << 12) + static_cast<std::int32_t>((crossing[0].x << 4) + ((t_q12 * d1x) >> 8)));
  shape.v = Pixel::from_raw((v << 12) + static_cast<std::int32_t>((crossing[0].y << 4) + ((t_q12 * d1y) >> 8)));
  // Clockwise from crossing 0: bright after it when the level rises there. Between crossing 0 and 1 the distance to
  // edge 1 with normal (-d1y, d1x) is negative and the distance to edge 2 with normal (-d2y, d2x) positive.
  shape.n1 = {static_cast<std::int32_t>(-d1y), static_cast<std::int32_t>(d1x)};
  shape.n2 = {static_cast<std::int32_t>(-d2y), static_cast<std::int32_t>(d2x)};
  if (!first_falls) shape.n2 = {-shape.n2.x, -shape.n2.y};
  return normalise(shape.n1) && normalise(shape.n2);
}

bool fit_corner(const GrayView& image, const CornerShape& start, const CornerFitOptions& options, CornerFit& fit) {
  const int w = options.half_window;
  const int cu = start.u.round(), cv = start.v.round();
  if (!image.contains(cu, cv, w)) return false;
  State state;
  state.x = (static_cast<std::int64_t>(start.u.raw()) << 4) - (static_cast<std::int64_t>(cu) << 16);
  state.y = (static_cast<std::int64_t>(start.v.raw()) << 4) - (static_cast<std::int64_t>(cv) << 16);
  state.n1 = start.n1;
  state.n2 = start.n2;
  state.blur = std::clamp(start.blur_q12, kMinBlur, kMaxBlur);
  if (!start_levels(image, cu, cv, w, state)) return false;

  constexpr std::int64_t kSmallMove = (1 << 16) / 256;  // below this the next step would be lost in the noise
  const std::int64_t start_x = state.x, start_y = state.y;
  const std::int64_t min_contrast = static_cast<std::int64_t>(options.min_contrast) << 6;
  Normal normal;
  FixedCholesky<kUnknowns> solver;
  int iteration = 0;
  for (;; ++iteration) {
    if (state.contrast < min_contrast) return false;
    if (std::abs(cross_q14(state)) < (1 << 14) / 4) return false;  // less than 14 degrees between the edges
    normal = Normal{};
    accumulate(image, cu, cv, w, state, normal);
    if (!solver.factor(normal.matrix)) return false;
    std::array<std::int64_t, kUnknowns> step;
    solver.solve(normal.right, 12 + 8, step);  // grey levels in Q14 for a whole column
    const std::int64_t c = state.contrast << 8;  // Q14
    // Moves along the normals, Q16 px, and turns, Q14.
    const std::int64_t move1 = -divide_rounded(step[kMove1] * (state.blur << 4), c);
    const std::int64_t move2 = -divide_rounded(step[kMove2] * (state.blur << 4), c);
    const std::int64_t turn1 = clamp(divide_rounded(step[kTurn1] * (state.blur << 2), c), 1 << 12);
    const std::int64_t turn2 = clamp(divide_rounded(step[kTurn2] * (state.blur << 2), c), 1 << 12);
    const std::int64_t det = cross_q14(state);
    const auto over_det = [det](std::int64_t a) { return det > 0 ? divide_rounded(a, det) : divide_rounded(-a, -det); };
    const std::int64_t dx = clamp(over_det(state.n2.y * move1 - state.n1.y * move2), 1 << 16);
    const std::int64_t dy = clamp(over_det(-state.n2.x * move1 + state.n1.x * move2), 1 << 16);
    state.x += dx;
    state.y += dy;
    const auto turn = [](Direction& n, std::int64_t angle) {
      const Direction old = n;
      n.x += static_cast<std::int32_t>((-old.y * angle) >> 14);
      n.y += static_cast<std::int32_t>((old.x * angle) >> 14);
      return normalise(n);
    };
    if (!turn(state.n1, turn1) || !turn(state.n2, turn2)) return false;
    state.mean += shift_rounded(step[kMean], 8);
    state.contrast += shift_rounded(step[kContrast], 8);
    const std::int64_t widen = clamp(-divide_rounded(step[kBlur] * state.blur, c), state.blur / 3);
    state.blur = std::clamp<std::int64_t>(state.blur + widen, kMinBlur, kMaxBlur);
    if (std::abs(state.x - start_x) > (static_cast<std::int64_t>(options.max_travel_q12) << 4) ||
        std::abs(state.y - start_y) > (static_cast<std::int64_t>(options.max_travel_q12) << 4))
      return false;
    // The corner must stay well inside its window, or half the edges are not seen.
    if (std::abs(state.x) > ((w - 1) << 16) || std::abs(state.y) > ((w - 1) << 16)) return false;
    // The levels and the blur too, or the residual would overstate the noise.
    const bool still = std::max(std::abs(dx), std::abs(dy)) < kSmallMove && std::abs(widen) < state.blur / 32 &&
                       std::max(std::abs(turn1), std::abs(turn2)) < (1 << 14) / 64;
    if (still) break;
    if (iteration + 1 >= options.max_iterations) return false;
  }

  const std::int64_t pixels = static_cast<std::int64_t>(2 * w + 1) * (2 * w + 1);
  // Residual of the last but one state: an upper estimate by less than the last step's effect.
  const std::int64_t variance_q12 = divide_rounded(normal.squares, pixels - kUnknowns);
  const std::int64_t residual_q6 = isqrt(static_cast<std::uint64_t>(variance_q12));
  if (residual_q6 * 100 > state.contrast * options.max_residual_percent) return false;

  // Covariance of the moves along the normals: variance (blur / c)^2 (A^-1); to image axes through N^-1; its mean.
  std::array<std::int64_t, kUnknowns> unit{}, column1{}, column2{};
  unit[kMove1] = std::int64_t{1} << 24;  // Q12 columns twice: A^-1 in units of one grey level per column
  solver.solve(unit, 12, column1);
  unit[kMove1] = 0;
  unit[kMove2] = std::int64_t{1} << 24;
  solver.solve(unit, 12, column2);
  // trace(N^-1 C N^-T) = (C11 + C22 - 2 rho C12) / det^2 for unit normals.
  const std::int64_t rho =
      (static_cast<std::int64_t>(state.n1.x) * state.n2.x + static_cast<std::int64_t>(state.n1.y) * state.n2.y) >> 14;
  const std::int64_t det = cross_q14(state);
  const std::int64_t trace_q12 = column1[kMove1] + column2[kMove2] - ((2 * rho * column1[kMove2]) >> 14);
  const std::int64_t trace_over_det_q12 = divide_rounded(trace_q12 << 14, std::max<std::int64_t>((det * det) >> 14, 1));
  // sigma^2 per axis = trace/2 * variance * blur^2 / c^2; with residual and contrast both Q6 their ratio is pure.
  const std::int64_t root_q12 = isqrt(static_cast<std::uint64_t>(std::max<std::int64_t>(trace_over_det_q12, 0)) << 11);
  const std::int64_t noise_over_contrast_q20 = divide_rounded(residual_q6 << 20, state.contrast);
  const std::int64_t sigma_q12 =
      shift_rounded(((root_q12 * noise_over_contrast_q20) >> 8) * state.blur, 24);

  fit.shape.u = Pixel::from_raw(static_cast<std::int32_t>((static_cast<std::int64_t>(cu) << 12) + shift_rounded(state.x, 4)));
  fit.shape.v = Pixel::from_raw(static_cast<std::int32_t>((static_cast<std::int64_t>(cv) << 12) + shift_rounded(state.y, 4)));
  fit.shape.n1 = state.n1;
  fit.shape.n2 = state.n2;
  fit.shape.blur_q12 = static_cast<std::int32_t>(state.blur);
  fit.corner.u = fit.shape.u;
  fit.corner.v = fit.shape.v;
  fit.corner.sigma_q12 = static_cast<std::uint32_t>(std::max<std::int64_t>(sigma_q12, 1));
  fit.corner.mean = static_cast<std::uint8_t>(std::clamp<std::int64_t>(state.mean >> 6, 0, 255));
  fit.corner.contrast = static_cast<std::uint8_t>(std::clamp<std::int64_t>(state.contrast >> 6, 0, 255));
  fit.residual_q6 = static_cast<std::int32_t>(residual_q6);
  fit.iterations = iteration + 1;
  return true;
}

}  // namespace srd::dsp
