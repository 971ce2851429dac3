// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/surface_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

ModeList free_list() {
  std::vector<Mode> modes;
  for (const char* name : {"A00", "B", "C", "A90", "A09", "A45", "A33", "A17"}) modes.push_back(*Mode::parse(name));
  return ModeList::make(modes).value();
}

SurfaceModel<double> model_of(const ModeList& modes) { return {modes, 240, 440, 12, -7}; }

TEST(SurfaceModel, HeightIsTheSumOfItsModes) {
  const SurfaceModel<double> model = model_of(ModeList::standard(12).value());
  const auto a = fakes::wavy(12);
  const double x = 55, y = 310, u = fakes::kPi * (x - 12) / 240, v = fakes::kPi * (y + 7) / 440;
  const double expected = a[0] + a[1] * (x - 12) / 240 + a[2] * (y + 7) / 440 + a[3] * std::cos(u) + a[4] * std::cos(v) +
                          a[5] * std::cos(2 * u) + a[6] * std::cos(2 * v) + a[7] * std::cos(u) * std::cos(v) +
                          a[8] * std::cos(3 * u) + a[9] * std::cos(3 * v) + a[10] * std::cos(2 * u) * std::cos(v) +
                          a[11] * std::cos(u) * std::cos(2 * v);
  EXPECT_NEAR(model.height(a, x, y), expected, 1e-12);
}

TEST(SurfaceModel, SlopesAndCurvaturesAreDifferences) {
  for (const ModeList& modes : {ModeList::standard(12).value(), free_list()}) {
    const SurfaceModel<double> model = model_of(modes);
    const auto a = fakes::wavy(modes.size());
    for (const double x : {-30.0, 0.0, 77.0, 240.0})
      for (const double y : {-11.0, 200.0, 430.0}) {
        constexpr double kStep = 1e-3;  // mm; the third derivatives are below 1e-3/mm^2
        const SurfaceSample<double> at = model.sample(a, x, y);
        const SurfaceSample<double> east = model.sample(a, x + kStep, y), west = model.sample(a, x - kStep, y);
        const SurfaceSample<double> north = model.sample(a, x, y + kStep), south = model.sample(a, x, y - kStep);
        EXPECT_NEAR(at.zx, (east.z - west.z) / (2 * kStep), 1e-8);
        EXPECT_NEAR(at.zy, (north.z - south.z) / (2 * kStep), 1e-8);
        EXPECT_NEAR(at.zxx, (east.zx - west.zx) / (2 * kStep), 1e-8);
        EXPECT_NEAR(at.zxy, (north.zx - south.zx) / (2 * kStep), 1e-8);
        EXPECT_NEAR(at.zxy, (east.zy - west.zy) / (2 * kStep), 1e-8);
        EXPECT_NEAR(at.zyy, (north.zy - south.zy) / (2 * kStep), 1e-8);
      }
  }
}

TEST(SurfaceModel, BasisIsWhatOneCoefficientAdds) {
  const SurfaceModel<double> model = model_of(free_list());
  const auto a = fakes::wavy(model.modes.size());
  Basis<double> basis;
  model.basis(91, 133, basis);
  const SurfaceSample<double> before = model.sample(a, 91, 133);
  for (int j = 0; j < model.modes.size(); ++j) {
    auto raised = a;
    raised[j] += 1;
    const SurfaceSample<double> after = model.sample(raised, 91, 133);
    EXPECT_NEAR(after.z - before.z, basis.value[j], 1e-12);
    EXPECT_NEAR(after.zx - before.zx, basis.dx[j], 1e-12);
    EXPECT_NEAR(after.zy - before.zy, basis.dy[j], 1e-12);
  }
}

TEST(ModeList, PublishedPrefixesHaveTheOrderOfTheirFiles) {
  const char* const order[] = {"A00", "B", "C", "A10", "A01", "A20", "A02", "A11", "A30", "A03", "A21", "A12"};
  for (const int parameters : {1, 3, 5, 8, 12}) {
    const auto list = ModeList::standard(parameters);
    ASSERT_TRUE(list.ok());
    ASSERT_EQ(list->size(), parameters);
    for (int i = 0; i < parameters; ++i) EXPECT_STREQ((*list)[i].name().data(), order[i]);
  }
  for (const int parameters : {-1, 0, 2, 4, 6, 13, 24}) EXPECT_FALSE(ModeList::standard(parameters).ok());
}

TEST(Mode, NamesComeBack) {
  for (const char* name : {"A00", "A09", "A90", "A37", "B", "C"}) {
    const auto mode = Mode::parse(name);
    ASSERT_TRUE(mode.has_value()) << name;
    EXPECT_STREQ(mode->name().data(), name);
  }
  for (const char* name : {"", "A", "A1", "A123", "A1x", "Ax1", "D", "a00", "B0", "BC", "A-1"})
    EXPECT_FALSE(Mode::parse(name).has_value()) << name;
}

TEST(ModeList, RefusesWhatIsNoModel) {
  const auto refused = [](std::vector<Mode> modes) { return ModeList::make(modes).error(); };
  EXPECT_EQ(refused({}), Errc::kInvalidArgument);
  EXPECT_EQ(refused({*Mode::parse("A11"), *Mode::parse("A11")}), Errc::kInvalidArgument);
  EXPECT_EQ(refused({Mode{Mode::Kind::kCosine, 10, 0}}), Errc::kInvalidArgument);
  EXPECT_EQ(refused({Mode{Mode::Kind::kSlopeX, 1, 0}}), Errc::kInvalidArgument);
  std::vector<Mode> many;
  for (int i = 0; i < 25; ++i)
    many.push_back({Mode::Kind::kCosine, static_cast<std::uint8_t>(i / 10), static_cast<std::uint8_t>(i % 10)});
  EXPECT_EQ(refused(many), Errc::kTooSmall);
  many.pop_back();
  EXPECT_TRUE(ModeList::make(many).ok());
}

TEST(ModeList, KnowsWhereAModeIs) {
  const ModeList list = free_list();
  EXPECT_EQ(list.index_of(*Mode::parse("A00")), 0);
  EXPECT_EQ(list.index_of(*Mode::parse("A45")), 5);
  EXPECT_EQ(list.index_of(*Mode::parse("A54")), -1);
}

}  // namespace
}  // namespace srd::dsp
