// SPDX-License-Identifier: Apache-2.0
#include "host/study/study.hpp"

#include <gtest/gtest.h>

#include "host/study/lower_bound.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::study {
namespace {

TEST(SlowStudy, WritesWhatItMeasuredAndReplacesNothingUnasked) {
  const fakes::ScratchFolder folder;
  StudyOptions options{folder.path() / "out", true, false, {}};
  int done = 0, all = 0;
  options.progress = [&](int now, int of) { done = now, all = of; };
  const auto files = study(options);
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_EQ(done, all);
  for (const auto& file : *files) EXPECT_GT(std::filesystem::file_size(file), 100u) << file;
  const std::string page = fakes::bytes_of(files->front());
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("A quick run"), std::string::npos);
  const auto again = study(options);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().exit, Exit::kUsage);
}

TEST(SlowStudy, CornersAreBetweenTheBoundAndOpencv) {
  const auto rows = study_corners(true, {});
  ASSERT_TRUE(rows);
  for (const CornerRow& row : *rows) {
    EXPECT_GE(row.found, row.corners * 98 / 100) << row.varied << " " << row.value();
    EXPECT_GT(row.rms_px, 0.9 * row.bound_px) << row.varied << " " << row.value();
    EXPECT_LT(row.rms_px, row.opencv_px) << row.varied << " " << row.value();
  }
}

TEST(LowerBound, IsTheInverseOfWhatCentralDifferencesSay) {
  const auto scene = fakes::flume_scene(5, 1);
  const Tank tank{scene.views, scene.points, scene.model, scene.media};
  const auto bound = information_bound(tank, 0, scene.truth, 0.1);
  ASSERT_TRUE(bound);
  dsp::InformationMatrix<double> differences = dsp::InformationMatrix<double>::Zero(5, 5);
  constexpr double kStep = 1e-4;  // mm
  for (const auto& point : scene.points) {
    Eigen::Matrix<double, 2, 5> jacobian;
    for (int j = 0; j < 5; ++j) {
      fakes::Scene up = scene, down = scene;
      up.truth[j] += kStep;
      down.truth[j] -= kStep;
      const auto& camera = scene.views[0].camera;
      jacobian.col(j) = (camera.pixel(up.seen(0, point)) - camera.pixel(down.seen(0, point))) / (2 * kStep);
    }
    differences += jacobian.transpose() * jacobian / 0.01;
  }
  EXPECT_LT((*bound - differences).norm() / differences.norm(), 1e-6);
}

TEST(LowerBound, OfACornerIsTheDesignsNumber) { EXPECT_NEAR(corner_bound(200, 0.9, 2, 5), 0.0055, 0.0001); }

}  // namespace
}  // namespace srd::study
