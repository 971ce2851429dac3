// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/pattern_metric/pattern_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace srd::dsp {
namespace {

// Of the levels' normal matrix scaled to a unit diagonal: below, the region shows next to nothing of one colour.
constexpr double kMinLevelPivot = 1e-6;
// Rounding of one predicted grey level: 1e-9 mm of a traced ray, times the steepest edges.
constexpr double kGreyRounding = 1e-8;
constexpr double kHuber = 1.345;  // deviations; 95 % efficient for normal noise
constexpr double kNormalPerMedian = 1.4826;

}  // namespace

PatternProblem::PatternProblem(const View<double>& view, const Region& region, const PatternSurface& surface,
                               const Media<double>& media, const CheckerPlane& plane, bool gradients)
    : view_(view),
      region_(region),
      surface_(surface),
      media_(media),
      plane_(plane),
      n_levels_(gradients ? PatternLevels::kMax : 2) {
  const int width = std::max(0, region.u1 - region.u0), height = std::max(0, region.v1 - region.v0);
  pixels_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  samples_.resize(pixels_.size());
  scores_.resize(pixels_.size() + 1);
  sizes_.resize(pixels_.size());
  const double half_u = std::max(1.0, 0.5 * (width - 1)), half_v = std::max(1.0, 0.5 * (height - 1));
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      Pixel& pixel = pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
      pixel.u = static_cast<float>(u / half_u - 1);
      pixel.v = static_cast<float>(v / half_v - 1);
      const auto xy = view.camera.undistort(Vec2<double>(region.u0 + u, region.v0 + v));
      if (!xy) continue;
      Mat2<double> pixel_xy, xy_pixel;
      (void)view.camera.pixel(*xy, &pixel_xy);
      if (!invert(pixel_xy, xy_pixel)) continue;
      Eigen::Matrix<double, 3, 2> d_xy;
      pixel.direction = view.ray(*xy, &d_xy).direction;
      pixel.d_pixel = (d_xy * xy_pixel).cast<float>();
      pixel.sees = pixel.direction.z() < 0;
    }
}

int PatternProblem::load(const GrayView& image, std::span<const std::uint8_t> mask) {
  n_used_ = 0;
  const bool whole = region_.u0 >= 0 && region_.v0 >= 0 && region_.u1 <= image.width && region_.v1 <= image.height;
  if (!whole || (!mask.empty() && mask.size() != pixels_.size())) return 0;
  const int width = region_.u1 - region_.u0;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (!pixels_[i].sees || (!mask.empty() && mask[i] == 0)) continue;
    Sample& sample = samples_[static_cast<std::size_t>(n_used_++)];
    sample.pixel = static_cast<int>(i);
    sample.column = static_cast<int>(i) % width;
    sample.row = static_cast<int>(i) / width;
    sample.along = 0;
    sample.weight = 1;
    sample.grey = image.row(region_.v0 + sample.row)[region_.u0 + sample.column];
  }
  // The best plane of grey levels, about the pixels' own centre.
  Vec3<double> centre = Vec3<double>::Zero();
  Mat3<double> squares = Mat3<double>::Zero();
  const auto place = [&](int i) {
    const Sample& sample = samples_[static_cast<std::size_t>(i)];
    const Pixel& pixel = pixels_[static_cast<std::size_t>(sample.pixel)];
    return Vec3<double>(static_cast<double>(pixel.u), static_cast<double>(pixel.v), sample.grey);
  };
  for (int i = 0; i < n_used_; ++i) centre += place(i) / n_used_;
  for (int i = 0; i < n_used_; ++i) {
    const Vec3<double> off = place(i) - centre;
    squares += off * off.transpose();
  }
  flat_squares_ = squares(2, 2);
  Mat2<double> inverse;
  if (n_levels_ == PatternLevels::kMax && invert(Mat2<double>(squares.topLeftCorner<2, 2>()), inverse))
    flat_squares_ -= squares.topRightCorner<2, 1>().dot(inverse * squares.topRightCorner<2, 1>());
  return n_used_;
}

bool PatternProblem::start_from(const Coefficients<double>& a) {
  double scale = 0;
  const Vec3<double> origin = view_.pose.centre();
  for (int i = 0; i < n_used_; ++i) {
    Sample& sample = samples_[static_cast<std::size_t>(i)];
    const Pixel& pixel = pixels_[static_cast<std::size_t>(sample.pixel)];
    Trace<double> way;
    // The last frame's distance may belong to another surface: the level of this one is the better start.
    if (!surface_.follow({origin, pixel.direction}, a, media_, plane_.z, way, 0)) return false;
    sample.along = way.distance;
    const Mat2<double> b_pixel = way.d_direction * pixel.d_pixel.cast<double>() / plane_.square_mm;
    const double wide_x = b_pixel.row(0).norm(), wide_y = b_pixel.row(1).norm();
    if (!(wide_x > 0) || !(wide_y > 0) || !std::isfinite(wide_x + wide_y)) return false;
    sample.blur = {1 / wide_x, 1 / wide_y, b_pixel.row(0).dot(b_pixel.row(1)) / (wide_x * wide_y)};
    scale += std::abs(b_pixel(0, 0) * b_pixel(1, 1) - b_pixel(0, 1) * b_pixel(1, 0));
  }
  square_px_ = std::sqrt(n_used_ / scale);
  return n_used_ > 0 && std::isfinite(square_px_);
}

bool PatternProblem::follow(const Coefficients<double>& unknowns, Sample& sample) {
  const Pixel& pixel = pixels_[static_cast<std::size_t>(sample.pixel)];
  Trace<double> way;
  if (!surface_.follow({view_.pose.centre(), pixel.direction}, unknowns, media_, plane_.z, way, sample.along)) return false;
  sample.along = way.distance;
  sample.surface_point = way.surface_point;
  const double per_square = 1 / plane_.square_mm;
  CheckerSample seen = blurred_checker((way.bottom.x() - plane_.x) * per_square, (way.bottom.y() - plane_.y) * per_square,
                                       sample.blur, blur_px_);
  const double sign = plane_.dark ? 1 : -1;
  const Vec2<double> gradient = sign * per_square * Vec2<double>(seen.by_x, seen.by_y);
  sample.shape = sign * seen.shape;
  sample.flat = seen.flat;
  sample.by_blur = sign * seen.by_blur;
  sample.by_height = gradient.dot(way.d_height);
  sample.by_slope_x = gradient.dot(way.d_slope.col(0));
  sample.by_slope_y = gradient.dot(way.d_slope.col(1));
  return true;
}

PatternProblem::LevelVector PatternProblem::regressors(const Sample& sample) const {
  LevelVector out = LevelVector::Zero();
  if (n_levels_ == 2) {
    out.head<2>() << 1, sample.shape;
    return out;
  }
  const Pixel& pixel = pixels_[static_cast<std::size_t>(sample.pixel)];
  const double u = static_cast<double>(pixel.u), v = static_cast<double>(pixel.v);
  out << 1, u, v, sample.shape, sample.shape * u, sample.shape * v;
  return out;
}

bool PatternProblem::solve_levels() {
  LevelMatrix sums = LevelMatrix::Zero();
  LevelVector greys = LevelVector::Zero();
  for (int i = 0; i < n_used_; ++i) {
    const Sample& sample = samples_[static_cast<std::size_t>(i)];
    if (skips(sample)) continue;
    const LevelVector r = regressors(sample);
    sums += sample.weight * r * r.transpose();
    greys += sample.weight * sample.grey * r;
  }
  for (int i = n_levels_; i < PatternLevels::kMax; ++i) sums(i, i) = 1;
  LevelVector unit;
  for (int i = 0; i < PatternLevels::kMax; ++i) {
    if (!(sums(i, i) > 0) || !std::isfinite(sums(i, i))) return false;
    unit[i] = 1 / std::sqrt(sums(i, i));
  }
  const LevelMatrix scaled = unit.asDiagonal() * sums * unit.asDiagonal();
  const Eigen::LDLT<LevelMatrix> factors(scaled);
  if (!(factors.vectorD().minCoeff() > kMinLevelPivot)) return false;
  level_inverse_ = unit.asDiagonal() * factors.solve(LevelMatrix::Identity()) * unit.asDiagonal();
  const LevelVector solved = level_inverse_ * greys;
  levels_ = {};
  const std::size_t half = static_cast<std::size_t>(n_levels_ / 2);
  for (std::size_t i = 0; i < half; ++i) {
    levels_.mean[i] = solved[static_cast<Eigen::Index>(i)];
    levels_.contrast[i] = solved[static_cast<Eigen::Index>(half + i)];
  }
  return levels_.contrast[0] > 0;
}

bool PatternProblem::row(const Sample& sample, Coefficients<double>& out) {
  if (sample.flat) return false;
  const Pixel& pixel = pixels_[static_cast<std::size_t>(sample.pixel)];
  const double contrast = levels_.contrast[0] + levels_.contrast[1] * static_cast<double>(pixel.u) +
                          levels_.contrast[2] * static_cast<double>(pixel.v);
  surface_.basis(sample.surface_point, basis_);
  const Eigen::Index n = basis_.value.size();
  out.resize(n_unknowns_);
  out.head(n) = contrast * (sample.by_height * basis_.value + sample.by_slope_x * basis_.dx + sample.by_slope_y * basis_.dy);
  if (n_unknowns_ > n) out[n] = contrast * sample.by_blur;
  return true;
}

double PatternProblem::predicted(const Sample& sample) const {
  const LevelVector r = regressors(sample);
  const std::size_t half = static_cast<std::size_t>(n_levels_ / 2);
  double sum = 0;
  for (std::size_t i = 0; i < half; ++i)
    sum += levels_.mean[i] * r[static_cast<Eigen::Index>(i)] + levels_.contrast[i] * r[static_cast<Eigen::Index>(half + i)];
  return sum;
}

bool PatternProblem::evaluate(const Coefficients<double>& unknowns, NormalEquations& out) {
  const Eigen::Index n = surface_.parameters();
  n_unknowns_ = static_cast<int>(unknowns.size());
  blur_px_ = held_blur_px_ > 0 ? held_blur_px_ : unknowns[n];
  // Three edges stand for the whole square wave only while a square spans several sigmas.
  if (!(blur_px_ > 0) || !(square_px_ >= kMinPerSigma * blur_px_)) return false;
  const Coefficients<double> a = unknowns.head(n);
  for (int i = 0; i < n_used_; ++i) {
    Sample& sample = samples_[static_cast<std::size_t>(i)];
    if (!skips(sample) && !follow(a, sample)) return false;
  }
  if (!solve_levels()) return false;

  out.reset(n_unknowns_);
  coupling_.setZero(n_unknowns_, PatternLevels::kMax);
  Coefficients<double> j;
  for (int i = 0; i < n_used_; ++i) {
    const Sample& sample = samples_[static_cast<std::size_t>(i)];
    if (skips(sample)) continue;
    const double e = predicted(sample) - sample.grey;
    out.squares += e * e;
    out.cost += sample.weight * e * e;
    out.error += std::abs(e);
    if (!row(sample, j)) continue;
    out.jtj.topLeftCorner(n_unknowns_, n_unknowns_).noalias() += sample.weight * j * j.transpose();
    out.jte.head(n_unknowns_) += (sample.weight * e) * j;
    coupling_.noalias() += sample.weight * j * regressors(sample).transpose();
  }
  out.jtj.topLeftCorner(n_unknowns_, n_unknowns_) -=
      coupling_.lazyProduct(level_inverse_).eval().lazyProduct(coupling_.transpose());
  const double rounding = kGreyRounding * std::sqrt(static_cast<double>(n_used_));
  out.cost_noise = 3 * rounding * (std::sqrt(out.cost) + rounding) + 16 * std::numeric_limits<double>::epsilon() * out.cost;
  return true;
}

double PatternProblem::reweigh() {
  const auto sizes = std::span(sizes_).first(static_cast<std::size_t>(n_used_));
  for (std::size_t i = 0; i < sizes.size(); ++i)
    sizes[i] = static_cast<float>(std::abs(predicted(samples_[i]) - samples_[i].grey));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  // A grey level's own rounding is the least scale.
  const double deviation = std::max(kNormalPerMedian * static_cast<double>(*middle), 0.3);
  const double limit = kHuber * deviation;
  for (int i = 0; i < n_used_; ++i) {
    Sample& sample = samples_[static_cast<std::size_t>(i)];
    const double size = std::abs(predicted(sample) - sample.grey);
    sample.weight = size > limit ? limit / size : 1;
  }
  return deviation;
}

void PatternProblem::sandwich(int block_px, Sandwich& out) {
  const int width = region_.u1 - region_.u0, across = (width + block_px - 1) / block_px;
  const int down = (region_.v1 - region_.v0 + block_px - 1) / block_px;
  const auto all = std::span(scores_).first(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  for (Coefficients<double>& score : all) score.resize(0);
  out.bread = out.middle = InformationMatrix<double>::Zero(n_unknowns_, n_unknowns_);
  out.blocks = 0;
  Coefficients<double> j;
  for (int i = 0; i < n_used_; ++i) {
    const Sample& sample = samples_[static_cast<std::size_t>(i)];
    const int block = sample.row / block_px * across + sample.column / block_px;
    Coefficients<double>& score = all[static_cast<std::size_t>(block)];
    if (score.size() == 0) score = Coefficients<double>::Zero(n_unknowns_);
    const LevelVector levels = level_inverse_ * regressors(sample);
    Coefficients<double> free = -coupling_.lazyProduct(levels);
    if (row(sample, j)) free += j;
    score += (sample.weight * (predicted(sample) - sample.grey)) * free;
    if (sample.weight >= 1) out.bread.noalias() += free * free.transpose();
  }
  for (const Coefficients<double>& score : all) {
    if (score.size() == 0) continue;
    out.middle.noalias() += score.lazyProduct(score.transpose());
    ++out.blocks;
  }
}

}  // namespace srd::dsp
