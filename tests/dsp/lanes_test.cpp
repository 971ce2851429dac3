// SPDX-License-Identifier: Apache-2.0
#include "dsp/core/lanes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace srd::dsp {
namespace {

template <class S>
void expect_sine_and_cosine(double within) {
  constexpr int kLanes = Lanes<S>::kSize;
  for (int i = 0; i < 40000; i += kLanes) {
    Lanes<S> angle(0), sine(0), cosine(0);
    for (int lane = 0; lane < kLanes; ++lane) angle.set(lane, static_cast<S>((i + lane - 20000) * 0.05));
    sin_cos(angle, sine, cosine);
    for (int lane = 0; lane < kLanes; ++lane) {
      const double exact = static_cast<double>(angle[lane]);
      ASSERT_NEAR(static_cast<double>(sine[lane]), std::sin(exact), within) << exact;
      ASSERT_NEAR(static_cast<double>(cosine[lane]), std::cos(exact), within) << exact;
    }
  }
}

TEST(Lanes, SineAndCosineAreThoseOfTheirAngleInEveryQuarter) {
  expect_sine_and_cosine<float>(1.2e-7);
  expect_sine_and_cosine<double>(1e-15);
}

TEST(Lanes, SineOfNoNumberIsNone) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Lanes<float> sine(0), cosine(0);
    sin_cos(Lanes<float>(bad), sine, cosine);
    EXPECT_FALSE(std::isfinite(sine[0]));
    EXPECT_FALSE(std::isfinite(cosine[3]));
  }
}

}  // namespace
}  // namespace srd::dsp
