// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/fixed_point/fixed_residual.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dsp/estimate/residual/ray_residual.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

// 64-bit arithmetic that counts every overflow, every shift that loses the sign and every division by nothing.
class Checked {
 public:
  static inline int faults = 0;
  static inline std::int64_t largest = 0;

  Checked() = default;
  template <class Whole>
  explicit Checked(Whole x) : x_(static_cast<std::int64_t>(x)) {}
  explicit operator std::int64_t() const { return x_; }

  friend Checked operator+(Checked a, Checked b) {
    std::int64_t out = 0;
    const bool fault = __builtin_add_overflow(a.x_, b.x_, &out);
    return note(fault, out);
  }
  friend Checked operator-(Checked a, Checked b) {
    std::int64_t out = 0;
    const bool fault = __builtin_sub_overflow(a.x_, b.x_, &out);
    return note(fault, out);
  }
  friend Checked operator*(Checked a, Checked b) {
    std::int64_t out = 0;
    const bool fault = __builtin_mul_overflow(a.x_, b.x_, &out);
    return note(fault, out);
  }
  friend Checked operator/(Checked a, Checked b) {
    if (b.x_ == 0 || (b.x_ == -1 && a.x_ == INT64_MIN)) return note(true, 0);
    return Checked(a.x_ / b.x_);
  }
  friend Checked operator-(Checked a) { return Checked(0) - a; }
  friend Checked operator>>(Checked a, int bits) { return Checked(a.x_ >> bits); }
  friend bool operator<(Checked a, Checked b) { return a.x_ < b.x_; }

 private:
  static Checked note(bool fault, std::int64_t x) {
    faults += fault ? 1 : 0;
    largest = std::max(largest, std::abs(x / 2));
    return Checked(x);
  }
  std::int64_t x_ = 0;
};

TEST(FixedTrigonometry, AgreesWithTheLibraryToSixBillionths) {
  double worst = 0;
  for (std::uint64_t turn = 0; turn < (std::uint64_t{1} << 32); turn += 1299709) {
    const SineCosine found = sin_cos_of_turn(static_cast<std::uint32_t>(turn));
    const double angle = 2 * fakes::kPi * static_cast<double>(turn) / 4294967296.0;
    worst = std::max({worst, std::abs(found.sine / 1073741824.0 - std::sin(angle)),
                      std::abs(found.cosine / 1073741824.0 - std::cos(angle))});
  }
  EXPECT_LT(worst, 6e-9);
  EXPECT_EQ(sin_cos_of_turn(0).cosine, 1 << 30);
  EXPECT_EQ(sin_cos_of_turn(1u << 30).sine, 1 << 30);
  EXPECT_EQ(sin_cos_of_turn(1u << 31).cosine, -(1 << 30));
  EXPECT_EQ(sin_cos_of_turn(3u << 30).sine, -(1 << 30));
}

// A tank of 0.2 to 2 m with water of 20 to 300 mm and slopes to 0.3, one camera 0.3 to 2 m off and up to 45 degrees from
// the vertical, none to two plates.
struct Geometry {
  View<double> view;
  SurfaceModel<double> model;
  Coefficients<double> a;
  Media<double> media;
  double lx = 0, ly = 0;
};

Geometry random_geometry(std::mt19937_64& random) {
  const auto between = [&](double least, double most) { return std::uniform_real_distribution<double>(least, most)(random); };
  Geometry out;
  out.lx = between(200, 2000);
  out.ly = between(200, 2000);
  const int count = std::uniform_int_distribution<int>(1, kMaxModes)(random);
  std::vector<Mode> all{{Mode::Kind::kSlopeX, 0, 0}, {Mode::Kind::kSlopeY, 0, 0}};
  for (std::uint8_t m = 0; m <= 6; ++m)
    for (std::uint8_t n = 0; n <= 6; ++n)
      if (m + n > 0) all.push_back({Mode::Kind::kCosine, m, n});
  std::shuffle(all.begin(), all.end(), random);
  std::vector<Mode> modes{Mode{}};
  modes.insert(modes.end(), all.begin(), all.begin() + count - 1);
  out.model.modes = ModeList::make(modes).value();
  out.model.lx = out.lx;
  out.model.ly = out.ly;
  out.model.x0 = between(-50, 50);
  out.model.y0 = between(-50, 50);
  const double depth = between(20, 300);
  out.a = Coefficients<double>::Zero(count);
  double slope = 0, bend = 0;
  for (int j = 1; j < count; ++j) {
    out.a[j] = between(-1, 1);
    const Mode& mode = out.model.modes[j];
    const double steep = mode.kind == Mode::Kind::kCosine ? fakes::kPi * std::hypot(mode.m / out.lx, mode.n / out.ly)
                                                          : 1 / std::min(out.lx, out.ly);
    slope += std::abs(out.a[j]) * steep;
    bend += std::abs(out.a[j]);
  }
  // Steepest slopes below 0.3, troughs above the plates.
  if (slope > 0) out.a *= std::min(between(0.02, 0.3) / slope, 0.35 * depth / bend);
  out.a[0] = depth;
  out.media.water = between(1.32, 1.36);
  out.media.n_layers = std::uniform_int_distribution<int>(0, 2)(random);
  for (std::size_t i = 0; i < 2; ++i) out.media.layers[i] = {between(1, 0.15 * depth), between(1.4, 1.6)};
  const Vec3<double> target(between(0, out.lx), between(0, out.ly), 0);
  const double azimuth = between(0, 2 * fakes::kPi), tilt = between(0, 0.75), off = between(300, 2000) + depth;
  out.view = fakes::look_at(
      fakes::flume_camera(),
      target + off * Vec3<double>(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)),
      target);
  return out;
}

TEST(FixedResidual, IsTheDoubleOneToATenThousandthOfAMillimetreWithoutOverflow) {
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal(0, 1);
  Checked::faults = 0;
  Checked::largest = 0;
  double worst = 0, squares = 0;
  int compared = 0, refused = 0;
  for (int draw = 0; draw < 3000; ++draw) {
    const Geometry geometry = random_geometry(random);
    const auto view = quantise(geometry.view);
    const auto surface = quantise(geometry.model, geometry.a);
    const auto media = quantise(geometry.media);
    ASSERT_TRUE(view && surface && media) << draw;
    const FixedResidual<Checked> checked(*view, *surface, *media);
    const FixedResidual<std::int64_t> plain(*view, *surface, *media);
    const Optics<double> optics = Optics<double>::make(geometry.model, geometry.media);
    for (int i = 0; i < 8; ++i) {
      const Vec3<double> point(std::uniform_real_distribution<double>(0, geometry.lx)(random),
                               std::uniform_real_distribution<double>(0, geometry.ly)(random), 0);
      const auto direct = geometry.view.normalised(point);
      // Within the field of a wide lens; measured a little beside where it would be seen dry.
      if (!direct || direct->norm() > 0.7) continue;
      Observation<double> seen;
      seen.normalised = *direct + 0.01 * Vec2<double>(normal(random), normal(random));
      PreparedCorner<double> corner;
      CornerResidual<double> expected{};
      expected.e = Vec2<double>::Zero();
      const WideView wide(geometry.view);
      if (!prepare(seen, point, wide, corner) || !prepare_ray(seen, wide, false, corner)) continue;
      corner.view = &geometry.view;
      start_at_level(geometry.a[0], true, corner);
      const bool valid = ray_residual<double>(Metric::kDisparity, optics, geometry.a, corner, nullptr, expected);
      const auto fixed_point = quantise(point);
      const auto fixed_seen = quantise(seen.normalised);
      ASSERT_TRUE(fixed_point && fixed_seen);
      std::array<FixedLength, 2> e{}, e_plain{};
      const bool found = checked.evaluate(*fixed_point, *fixed_seen, e);
      ASSERT_EQ(plain.evaluate(*fixed_point, *fixed_seen, e_plain), found);
      ASSERT_EQ(e_plain, e);
      if (!valid || !found) {
        ++refused;
        // Only for a reason: a ray too level, or a distance out of range.
        const double farthest = std::max(corner.camera_from_point.cwiseAbs().maxCoeff(), corner.dry.cwiseAbs().maxCoeff());
        EXPECT_FALSE(valid && corner.direction.z() < -0.3 && farthest < 4000) << corner.direction << " " << farthest;
        continue;
      }
      ++compared;
      const double off = (Vec2<double>(e[0].to<double>(), e[1].to<double>()) - expected.e).norm();
      worst = std::max(worst, off);
      squares += off * off;
      ASSERT_LT(off, 1e-4) << "draw " << draw << ", |e| " << expected.e.norm();
    }
  }
  EXPECT_EQ(Checked::faults, 0);
  EXPECT_GT(compared, 5000);
  EXPECT_LT(refused, compared / 20);
  RecordProperty("compared", compared);
  RecordProperty("refused", refused);
  RecordProperty("worst_mm", std::to_string(worst));
  RecordProperty("rms_nm", std::to_string(1e6 * std::sqrt(squares / compared)));
  RecordProperty("largest_bits", std::to_string(std::log2(2.0 * static_cast<double>(Checked::largest))));
}

TEST(FixedResidual, SaysNoWhereThereIsNoViewFromAbove) {
  fakes::Scene scene = fakes::flume_scene(1, 1);
  const auto view = quantise(scene.views[0]);
  const auto media = quantise(scene.media);
  const auto point = quantise(scene.points[100]);
  ASSERT_TRUE(view && media && point);
  // Over the horizon.
  const auto surface = quantise(scene.model, scene.truth);
  ASSERT_TRUE(surface);
  std::array<FixedLength, 2> e{};
  const auto up = quantise(Vec2<double>(1.1, 1.1)), down = quantise(Vec2<double>(0, 0));
  ASSERT_TRUE(up && down);
  EXPECT_TRUE(FixedResidual<std::int64_t>(*view, *surface, *media).evaluate(*point, *down, e));
  // Water under the plates.
  scene.media.n_layers = 1;
  scene.media.layers[0] = {90, 1.5};
  const auto plates = quantise(scene.media);
  ASSERT_TRUE(plates);
  EXPECT_FALSE(FixedResidual<std::int64_t>(*view, *surface, *plates).evaluate(*point, *down, e));
  // A camera that looks level.
  const View<double> level = fakes::look_at(fakes::flume_camera(), {900, 0, 400}, {-900, 0, 400.5});
  const auto level_view = quantise(level);
  ASSERT_TRUE(level_view);
  EXPECT_FALSE(FixedResidual<std::int64_t>(*level_view, *surface, *media).evaluate(*point, *down, e));
}

TEST(FixedResidual, RefusesNumbersOutsideItsRanges) {
  fakes::Scene scene = fakes::flume_scene(5, 1);
  EXPECT_TRUE(quantise(scene.model, scene.truth));
  scene.model.lx = 20;  // waves too short for the bits of a slope
  EXPECT_FALSE(quantise(scene.model, scene.truth));
  scene.model.lx = 240;
  scene.truth[3] = 1000;
  EXPECT_FALSE(quantise(scene.model, scene.truth));
  EXPECT_FALSE(quantise(Vec3<double>(0, 3000, 0)));
  EXPECT_FALSE(quantise(Vec3<double>(0, std::nan(""), 0)));
  EXPECT_FALSE(quantise(Vec2<double>(1.3, 0)));
  scene.views[0].pose.translation *= 5;
  EXPECT_FALSE(quantise(scene.views[0]));
  scene.media.layers[0] = {500, 1.5};
  scene.media.n_layers = 1;
  EXPECT_FALSE(quantise(scene.media));
}

}  // namespace
}  // namespace srd::dsp
