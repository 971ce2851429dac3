// SPDX-License-Identifier: Apache-2.0
// The surface from images of the simulated flume, against the truth and against the bound (19) at the corners' own error.
#include <gtest/gtest.h>

#include "tests/accuracy/flume_run.hpp"
#include "tests/bench/scenes.hpp"

namespace srd::accuracy {
namespace {

TEST(SlowFlume, FiveParametersAreWithinHundredthsOfAMillimetre) {
  const FlumeRun run = run_flume<float>(bench::flume_scene(), 60, 80, 6);
  run.print("flume, 5 parameters");
  EXPECT_EQ(run.lost, 0);
  EXPECT_EQ(run.wrong, 0);
  EXPECT_GE(run.used_percent, 98);
  EXPECT_LE(run.corner_rms_px, 0.015);
  EXPECT_LT(run.corner_rms_px, run.opencv_rms_px);
  EXPECT_LE(run.surface_rms_mm, 0.020);
  EXPECT_LE(run.surface_rms_mm, 1.3 * run.bound_rms_mm);
}

TEST(SlowFlume, EightParametersInPoorLightAreNearTheBound) {
  const FlumeRun run = run_flume<float>(bench::hard_flume_scene(), 60);
  run.print("flume, 8 parameters, poor light");
  EXPECT_EQ(run.lost, 0);
  EXPECT_EQ(run.wrong, 0);
  EXPECT_GE(run.used_percent, 90);
  EXPECT_LE(run.used_percent, 98);  // the glare was there
  EXPECT_LE(run.surface_rms_mm, 1.5 * run.bound_rms_mm);
}

// A camera with an image processor: reduced by area from twice the size, then sharpened. The same noise on the sensor.
TEST(SlowFlume, SharpenedFramesGiveTheSurfaceOfUnsharpenedOnes) {
  const HalvingCamera plain(0);
  const FlumeRun unsharpened = run_flume<float>(bench::flume_scene(), 8, 80, 0, &plain);
  unsharpened.print("flume, reduced");
  EXPECT_EQ(unsharpened.surfaces, 8);
  for (const double amount : {0.5, 1.0}) {
    const HalvingCamera camera(amount);
    const FlumeRun run = run_flume<float>(bench::flume_scene(), 8, 80, 0, &camera);
    run.print(amount < 1 ? "flume, reduced, unsharp mask 0.5" : "flume, reduced, unsharp mask 1");
    EXPECT_EQ(run.surfaces, 8);
    EXPECT_EQ(run.lost, 0);
    EXPECT_EQ(run.wrong, 0);
    EXPECT_LE(run.surface_rms_mm, 1.5 * unsharpened.surface_rms_mm);
  }
}

TEST(SlowFlume, FastWavesAreMeasuredAsSlowOnes) {
  const FlumeRun run = run_flume<float>(bench::fast_flume_scene(), 60);
  run.print("flume, fast waves");
  EXPECT_GE(run.fastest_px, 8);
  EXPECT_EQ(run.lost, 0);
  EXPECT_EQ(run.wrong, 0);
  EXPECT_GE(run.used_percent, 98);
  EXPECT_LE(run.corner_rms_px, 0.015);
  EXPECT_LE(run.surface_rms_mm, 0.020);
  EXPECT_LE(run.surface_rms_mm, 1.3 * run.bound_rms_mm);
}

}  // namespace
}  // namespace srd::accuracy
