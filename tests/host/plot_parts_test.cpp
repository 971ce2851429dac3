// SPDX-License-Identifier: Apache-2.0
// The parts that figures are made of: spectrum, time line, axes, contours, colours.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "host/plot/axis.hpp"
#include "host/plot/contour.hpp"
#include "host/plot/palette.hpp"
#include "host/plot/spectrum.hpp"
#include "host/plot/timeline.hpp"

namespace srd::host {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Sine {
  std::vector<double> seconds, values;
};

Sine sine(double hz, double amplitude, double rate, int n) {
  Sine s;
  for (int i = 0; i < n; ++i) {
    s.seconds.push_back(i / rate);
    s.values.push_back(80 + amplitude * std::sin(2 * M_PI * hz * i / rate + 0.3));
  }
  return s;
}

std::size_t peak(const Spectrum& s) {
  return static_cast<std::size_t>(std::max_element(s.amplitude.begin(), s.amplitude.end()) - s.amplitude.begin());
}

TEST(AmplitudeSpectrum, SineShowsItsAmplitudeAtItsFrequency) {
  // On a line of the untouched series (3 Hz), between two of them (3.05 Hz), fast, and with few samples.
  struct Case {
    double hz, amplitude, rate;
    int n;
  };
  for (const Case& c : {Case{3, 2.5, 50, 500}, Case{3.05, 2.5, 50, 500}, Case{21.3, 0.01, 50, 777}, Case{5, 1, 20, 64}}) {
    const Sine s = sine(c.hz, c.amplitude, c.rate, c.n);
    const Spectrum spectrum = amplitude_spectrum(s.seconds, s.values, 1 / c.rate);
    ASSERT_FALSE(spectrum.amplitude.empty());
    EXPECT_NEAR(c.rate / 2, spectrum.frequency_hz.back(), 1e-9);
    EXPECT_NEAR(c.hz, spectrum.frequency_hz[peak(spectrum)], 0.15 * spectrum.resolution_hz) << c.hz;
    EXPECT_NEAR(c.amplitude, spectrum.amplitude[peak(spectrum)], 0.01 * c.amplitude) << c.hz;
    EXPECT_EQ(0, spectrum.filled_fraction);
  }
}

TEST(AmplitudeSpectrum, LevelWaterHasNone) {
  const Sine s = sine(3, 0, 50, 300);
  const Spectrum spectrum = amplitude_spectrum(s.seconds, s.values, 0.02);
  EXPECT_LT(spectrum.amplitude[peak(spectrum)], 1e-10);
}

TEST(AmplitudeSpectrum, GapsAreFilledWithTheNearestAndCounted) {
  Sine s = sine(2, 1.5, 50, 1000);
  for (std::size_t i = 100; i < 110; ++i) s.values[i] = kNaN;         // no surface
  s.seconds.erase(s.seconds.begin() + 500, s.seconds.begin() + 510);  // no frame
  s.values.erase(s.values.begin() + 500, s.values.begin() + 510);
  const Spectrum spectrum = amplitude_spectrum(s.seconds, s.values, 0.02);
  EXPECT_NEAR(0.02, spectrum.filled_fraction, 1e-12);
  EXPECT_NEAR(2, spectrum.frequency_hz[peak(spectrum)], 0.02);
  EXPECT_NEAR(1.5, spectrum.amplitude[peak(spectrum)], 0.06);
}

TEST(AmplitudeSpectrum, SaysNothingOfTooLittle) {
  const Sine s = sine(2, 1.5, 50, 7);
  EXPECT_TRUE(amplitude_spectrum(s.seconds, s.values, 0.02).amplitude.empty());
  EXPECT_TRUE(amplitude_spectrum(s.seconds, s.values, 0).amplitude.empty());
  const Sine longer = sine(2, 1.5, 50, 20);
  const std::vector<double> none(20, kNaN);
  EXPECT_TRUE(amplitude_spectrum(longer.seconds, none, 0.02).amplitude.empty());
}

CoefficientRow frame(const std::string& boot, std::uint64_t sequence, double ms) {
  CoefficientRow row;
  row.boot = boot;
  row.sequence = sequence;
  row.time_ns = 1'000'000'000 + std::llround(ms * 1e6);
  return row;
}

TEST(Timeline, GapsAreNeverJoined) {
  CoefficientRun run;
  // 0 1 2 | 4 (one lost) 5 | 6 late by one interval | other boot | 1
  run.rows = {frame("a", 0, 0),   frame("a", 1, 20),  frame("a", 2, 40),  frame("a", 4, 80), frame("a", 5, 100),
              frame("a", 6, 140), frame("b", 0, 160), frame("b", 1, 180), frame("b", 2, 200)};
  const Timeline timeline = make_timeline(run);
  EXPECT_NEAR(0.02, timeline.interval_s, 1e-12);
  EXPECT_NEAR(0.2, timeline.seconds.back(), 1e-12);
  std::vector<double> values(9, 1.0);
  EXPECT_EQ((Stretches{{0, 3}, {3, 5}, {5, 6}, {6, 9}}), unbroken(timeline, values));
  values[1] = values[8] = kNaN;  // no surface
  EXPECT_EQ((Stretches{{0, 1}, {2, 3}, {3, 5}, {5, 6}, {6, 8}}), unbroken(timeline, values));
}

TEST(Axis, TicksAreRoundAndInside) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-6, 6), offset(-3, 3);
  for (int i = 0; i < 2000; ++i) {
    const double extent = std::pow(10, exponent(random));
    const double low = offset(random) * extent, high = low + extent;
    const auto at = ticks({low, high}, 6);
    ASSERT_GE(at.size(), 2u) << low << " " << high;
    ASSERT_LE(at.size(), 7u) << low << " " << high;
    const double step = at[1] - at[0];
    const double leading = step / std::pow(10, std::floor(std::log10(step) + 1e-6));
    EXPECT_TRUE(std::abs(leading - 1) < 1e-6 || std::abs(leading - 2) < 1e-6 || std::abs(leading - 5) < 1e-6) << step;
    for (const double t : at) {
      EXPECT_GE(t, low - 1e-6 * step);
      EXPECT_LE(t, high + 1e-6 * step);
      EXPECT_NEAR(std::round(t / step), t / step, 1e-6);
    }
  }
  EXPECT_EQ((std::vector<double>{0, 50, 100, 150, 200}), ticks({200, 0}, 5));
}

TEST(Axis, LabelsHaveTheDigitsThatTheStepNeeds) {
  EXPECT_EQ("80", tick_label(80, {79, 80, 81}));
  EXPECT_EQ("80.00", tick_label(80, {79.95, 80, 80.05}));
  EXPECT_EQ("\u22120.5", tick_label(-0.5, {-0.5, 0, 0.5}));
  EXPECT_EQ("0.001", tick_label(0.001, {}, true));
  EXPECT_EQ("1e-6", tick_label(1e-6, {}, true));
}

TEST(Axis, LongSeriesKeepTheirPeaks) {
  const Panel panel{{0, 0, 100, 50}, {0, 1}, {-1, 1}};
  std::vector<double> x, y;
  for (int i = 0; i < 50000; ++i) {
    x.push_back(i / 50000.0);
    y.push_back(0);
  }
  y[31234] = 1;  // one frame only
  y[31235] = -1;
  Scene scene(100, 50);
  draw_series(scene, panel, x, y, {{0, 50000}}, {kBlue, 1}, "series");
  ASSERT_EQ(1u, scene.shapes().size());
  const auto& line = std::get<Lines>(scene.shapes()[0]).parts.at(0);
  EXPECT_LT(line.size(), 1000u);
  double top = 50, bottom = 0;
  for (const Place& p : line) {
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  EXPECT_NEAR(0, top, 1e-9);
  EXPECT_NEAR(50, bottom, 1e-9);
}

TEST(Contour, FollowsACircleRoundOnce) {
  Eigen::MatrixXd z(41, 61);
  for (int y = 0; y < 41; ++y)
    for (int x = 0; x < 61; ++x) z(y, x) = std::hypot(x - 30.2, y - 20.3);
  const auto lines = contour_lines(z, 10);
  ASSERT_EQ(1u, lines.size());
  EXPECT_EQ(lines[0].front().x, lines[0].back().x);
  EXPECT_EQ(lines[0].front().y, lines[0].back().y);
  double length = 0;
  for (std::size_t i = 0; i < lines[0].size(); ++i) {
    EXPECT_NEAR(10, std::hypot(lines[0][i].x - 30.2, lines[0][i].y - 20.3), 0.03);
    if (i > 0) length += std::hypot(lines[0][i].x - lines[0][i - 1].x, lines[0][i].y - lines[0][i - 1].y);
  }
  EXPECT_NEAR(20 * M_PI, length, 0.3);
}

TEST(Contour, OpenLinesRunFromBorderToBorder) {
  Eigen::MatrixXd z(5, 9);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 9; ++x) z(y, x) = x;
  const auto lines = contour_lines(z, 2.5);
  ASSERT_EQ(1u, lines.size());
  EXPECT_EQ(5u, lines[0].size());
  for (const Place& p : lines[0]) EXPECT_NEAR(2.5, p.x, 1e-12);
  EXPECT_EQ(4, std::abs(lines[0].front().y - lines[0].back().y));
  EXPECT_TRUE(contour_lines(z, 20).empty());
}

TEST(Palette, MapGetsLighterAllTheWay) {
  double before = -1;
  for (int i = 0; i <= 100; ++i) {
    const Colour c = viridis(i / 100.0);
    const double lightness = 0.2126 * std::pow(c.red / 255.0, 2.2) + 0.7152 * std::pow(c.green / 255.0, 2.2) +
                             0.0722 * std::pow(c.blue / 255.0, 2.2);
    EXPECT_GT(lightness, before) << i;
    before = lightness;
  }
  EXPECT_EQ(viridis(0).blue, viridis(kNaN).blue);
}

}  // namespace
}  // namespace srd::host
