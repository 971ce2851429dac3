// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/refractive_index.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace srd::dsp {
namespace {

TEST(WaterRefractiveIndex, HasTheTabulatedValues) {
  EXPECT_NEAR(water_refractive_index(20, 0, 589).value(), 1.3330, 5e-5);
  // Tilton and Taylor's measurements against air, sodium light.
  EXPECT_NEAR(water_refractive_index(10, 0, 589.3).value(), 1.33369, 3e-5);
  EXPECT_NEAR(water_refractive_index(20, 0, 589.3).value(), 1.33299, 3e-5);
  EXPECT_NEAR(water_refractive_index(30, 0, 589.3).value(), 1.33192, 3e-5);
  // Standard sea water.
  EXPECT_NEAR(water_refractive_index(20, 35, 589.3).value(), 1.3394, 2e-4);
}

TEST(WaterRefractiveIndex, FallsWithTemperatureAndWavelengthAndRisesWithSalt) {
  const double at = water_refractive_index(20, 10, 550).value();
  EXPECT_LT(water_refractive_index(25, 10, 550).value(), at);
  EXPECT_LT(water_refractive_index(20, 10, 600).value(), at);
  EXPECT_GT(water_refractive_index(20, 15, 550).value(), at);
}

TEST(WaterRefractiveIndex, RefusesWhereTheEquationWasNotFitted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](double t, double s, double l) { return !water_refractive_index(t, s, l).ok(); };
  EXPECT_TRUE(refused(-0.1, 0, 589));
  EXPECT_TRUE(refused(30.1, 0, 589));
  EXPECT_TRUE(refused(20, -1, 589));
  EXPECT_TRUE(refused(20, 35.1, 589));
  EXPECT_TRUE(refused(20, 0, 399));
  EXPECT_TRUE(refused(20, 0, 701));
  EXPECT_TRUE(refused(nan, 0, 589));
  EXPECT_TRUE(refused(20, nan, 589));
  EXPECT_TRUE(refused(20, 0, nan));
  EXPECT_FALSE(refused(0, 35, 400));
  EXPECT_FALSE(refused(30, 0, 700));
}

}  // namespace
}  // namespace srd::dsp
