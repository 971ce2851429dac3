// SPDX-License-Identifier: Apache-2.0
// The systematic deviations of a run: from the errors in its cameras' files to the columns of its series.
#include "host/run/systematic.hpp"

#include <gtest/gtest.h>

#include "drivers/camera/simulator/scene.hpp"
#include "drivers/support/csv_table.hpp"
#include "host/run/series.hpp"

namespace srd::host {
namespace {

KnownErrors some_errors(double turn) {
  KnownErrors known;
  known.errors.pose.diagonal() << turn * turn, turn * turn, turn * turn, 0.01, 0.01, 0.01;
  known.pose_date = *parse_day("2026-11-28");
  return known;
}

// One frame of still water that every corner was seen through.
RunPlan still_run(std::vector<FrameRecord>& frames) {
  const Scene& scene = default_scene();
  RunPlan plan;
  RunCamera camera;
  camera.calibration = scene.calibration;
  camera.pose = scene.pose;
  plan.points = scene.points();
  plan.model = {dsp::ModeList::standard(3).value(), scene.surface.lx, scene.surface.ly, 0, 0};
  plan.media = scene.media;
  FrameRecord frame;
  frame.status = proto::FrameStatus::kOk;
  frame.estimate.stop = dsp::Stop::kGradient;
  frame.estimate.coefficients = dsp::Coefficients<double>::Zero(3);
  frame.estimate.coefficients[0] = 80;
  frame.corners.resize(1);
  for (int i = 0; i < static_cast<int>(plan.points.size()); ++i) {
    camera.points.push_back(i);
    frame.corners[0].emplace_back();
    frame.corners[0].back().point = i;
  }
  frames.push_back(frame);
  frame.estimate.stop = dsp::Stop::kTooFewCorners;  // and one without a surface
  frames.push_back(frame);
  plan.cameras.push_back(camera);
  return plan;
}

TEST(Systematic, StandsInTheSeriesAndItsSourcesInTheModel) {
  RunResult result;
  RunPlan plan = still_run(result.frames);
  plan.cameras[0].errors = some_errors(1e-4);
  plan.cameras[0].errors->calibration_date = 0;
  add_systematic(plan, result.frames);
  ASSERT_TRUE(result.frames[0].systematic);
  EXPECT_FALSE(result.frames[1].systematic);
  const auto table = CsvTable::parse(series_csv(plan, result), "surface.csv");
  ASSERT_TRUE(table) << table.error().text();
  const auto level = table->numbers("sys_A00"), height = table->numbers("sys_height_mm");
  ASSERT_TRUE(level && height);
  EXPECT_NEAR((*level)[0], result.frames[0].systematic->deviation[0], 1e-3 * (*level)[0]);
  // A turn of 0.1 mrad and a shift of 0.1 mm a camera 0.95 m away move heights by some tenths of a mm.
  EXPECT_GT((*height)[0], 0.02);
  EXPECT_LT((*height)[0], 2);
  EXPECT_TRUE(std::isnan((*level)[1]));
  const auto model = parse_model_file(series_model(plan, result), "model");
  ASSERT_TRUE(model) << model.error().text();
  ASSERT_TRUE(model->nodes[0].systematic);
  EXPECT_EQ(sources_text(*model->nodes[0].systematic), "the pose of 2026-11-28 and the calibration (of an unknown date)");
}

TEST(Systematic, GrowsWithTheErrorsOfThePose) {
  std::vector<FrameRecord> frames;
  RunPlan plan = still_run(frames);
  plan.cameras[0].errors = some_errors(1e-4);
  add_systematic(plan, frames);
  const double once = frames[0].systematic->deviation[0];
  plan.cameras[0].errors->errors.pose *= 9;
  add_systematic(plan, frames);
  EXPECT_NEAR(frames[0].systematic->deviation[0], 3 * once, 1e-9);
}

TEST(Systematic, IsNotKnownWhereACameraSaysNothingOrTheIndexIsFree) {
  std::vector<FrameRecord> frames;
  RunPlan plan = still_run(frames);
  add_systematic(plan, frames);
  EXPECT_FALSE(frames[0].systematic);
  EXPECT_FALSE(error_sources(plan));
  plan.cameras[0].errors = some_errors(1e-4);
  EXPECT_TRUE(error_sources(plan));
  plan.cameras.push_back(plan.cameras[0]);
  plan.cameras[1].errors->pose_date = *parse_day("2025-01-31");
  EXPECT_EQ(sources_text(*error_sources(plan)), "the pose of 2025-01-31; the calibration counts as exact");
  plan.cameras[1].errors.reset();
  EXPECT_FALSE(error_sources(plan)) << "one of two";
  plan.cameras.pop_back();
  plan.options.free_index = true;
  EXPECT_FALSE(error_sources(plan));
}

}  // namespace
}  // namespace srd::host
