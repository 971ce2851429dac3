// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/results.hpp"

#include <gtest/gtest.h>

#include "host/opensrd/frame_list.hpp"
#include "host/run/features.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host::opensrd {
namespace {

using fakes::bytes_of;
using fakes::ScratchFolder;

FrameRecord surface(double a0, double error) {
  FrameRecord frame;
  frame.estimate.stop = dsp::Stop::kGradient;
  frame.estimate.coefficients = fakes::coefficients({a0, -0.123456, 1e-9});
  frame.estimate.mean_error = error;
  frame.corners.resize(1);
  return frame;
}

Settings two_cameras() {
  Settings s;
  s.file = "/lab/run/settings.xml";
  s.cameras.resize(2);
  for (std::size_t c = 0; c < 2; ++c) {
    s.cameras[c].pose_output = "RESULTS/pose" + std::to_string(c + 1) + ".txt";
    s.cameras[c].features_output = "RESULTS/FEATURES/CAM" + std::to_string(c + 1);
  }
  s.coefficients_output = "RESULTS/Coefficients.txt";
  s.errors_output = "RESULTS/Errors.txt";
  return s;
}

TEST(OpenSrdResults, GuideAnd2016StartAtTheLastFrameAnd2017AtTheFirst) {
  FrameRecord lost;
  lost.corners.resize(1);
  const std::vector<FrameRecord> frames = {surface(1, 0.5), lost, surface(3, 0.0967649)};
  EXPECT_EQ(coefficients_text(Dialect::k2016, frames, 3),
            "[3.00000,-0.12346,0.00000]\n[nan,nan,nan]\n[1.00000,-0.12346,0.00000]\n");
  EXPECT_EQ(coefficients_text(Dialect::kGuide, frames, 3), coefficients_text(Dialect::k2016, frames, 3));
  EXPECT_EQ(coefficients_text(Dialect::k2017, frames, 3),
            "[1.00000,-0.12346,0.00000]\n[nan,nan,nan]\n[3.00000,-0.12346,0.00000]\n");
  EXPECT_EQ(errors_text(Dialect::k2016, frames), "0.0967649\nnan\n0.5\n");
}

TEST(OpenSrdResults, NamesKeepTheirFoldersBelowOut) {
  const auto plan = plan_outputs(two_cameras(), "/tmp/out", true, true);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->coefficients, "/tmp/out/RESULTS/Coefficients.txt");
  EXPECT_EQ(plan->poses.at(1), "/tmp/out/RESULTS/pose2.txt");
  EXPECT_EQ(plan->features.at(0), "/tmp/out/RESULTS/FEATURES/CAM1");
}

TEST(OpenSrdResults, NothingIsWrittenOutsideOut) {
  Settings s = two_cameras();
  s.coefficients_output = "/elsewhere/Documents/coeffs.txt";
  s.errors_output = "../../errors.txt";
  s.cameras[0].pose_output = "/lab/run/RESULTS/pose1.txt";  // in the settings' folder: its sub-folders stay
  s.cameras[1].features_output = "RESULTS/../../CAM2/";
  const auto plan = plan_outputs(s, "/tmp/out", true, true);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_EQ(plan->coefficients, "/tmp/out/coeffs.txt");
  EXPECT_EQ(plan->errors, "/tmp/out/errors.txt");
  EXPECT_EQ(plan->poses.at(0), "/tmp/out/RESULTS/pose1.txt");
  EXPECT_EQ(plan->features.at(1), "/tmp/out/CAM2");
}

TEST(OpenSrdResults, TwoResultsNeverShareAFile) {
  Settings s = two_cameras();
  s.cameras[1].pose_output = s.cameras[0].pose_output;
  const auto plan = plan_outputs(s, "/tmp/out", true, true);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().exit, Exit::kUsage);
  EXPECT_NE(plan.error().text().find("pose of camera 1 and the pose of camera 2"), std::string::npos) << plan.error().text();
  EXPECT_TRUE(plan_outputs(s, "/tmp/out", false, true));  // no poses are made: no clash
}

TEST(OpenSrdResults, ResultsOfAnEarlierRunAreKeptUnlessForced) {
  const ScratchFolder folder;
  const auto plan = plan_outputs(two_cameras(), folder.path(), true, true);
  ASSERT_TRUE(plan);
  ASSERT_TRUE(prepare_outputs(*plan, false));
  const auto old = folder.write("RESULTS/FEATURES/CAM2/Frame_7.txt", "0\t1\t2\n");
  const auto own = folder.write("RESULTS/FEATURES/CAM2/Frame_notes.txt", "mine");
  EXPECT_FALSE(check_free(*plan, false));
  const auto refused = prepare_outputs(*plan, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().exit, Exit::kUsage);
  EXPECT_TRUE(std::filesystem::exists(old));
  ASSERT_TRUE(prepare_outputs(*plan, true));
  EXPECT_FALSE(std::filesystem::exists(old));  // or two runs would mix
  EXPECT_TRUE(std::filesystem::exists(own));
}

TEST(OpenSrdResults, FeaturesComeBackAsWritten) {
  const ScratchFolder folder;
  const std::vector<Feature> written = {{0, 105.817932, 166.626923}, {84, -3.25, 1e-3}};
  ASSERT_TRUE(write_features(folder.path() / "f.txt", written));
  EXPECT_EQ(bytes_of(folder.path() / "f.txt"), "0\t105.817932\t166.626923\n84\t-3.250000\t0.001000\n");
  const auto read = read_features(folder.path() / "f.txt", 85);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[1].id, 84);
  EXPECT_EQ((*read)[1].u, -3.25);
}

TEST(OpenSrdResults, FeatureFilesAreUndistortedPixelsByTheCamerasOwnList) {
  const ScratchFolder folder;
  const auto camera = fakes::flume_camera();
  FrameRecord first = surface(1, 0), last = surface(2, 0);
  dsp::Observation<double> corner;
  corner.point = 5;
  corner.pixel = corner.normalised = {0.1, -0.05};
  first.corners[0] = {corner};
  const std::vector<FrameRecord> frames = {first, last};
  const std::vector<int> ids = {-1, -1, -1, -1, -1, 2};
  ASSERT_TRUE(write_feature_files(folder.path(), Dialect::kGuide, frames, 0, camera, ids));
  EXPECT_EQ(bytes_of(folder.path() / "Frame_0.txt"), "");
  const auto features = read_features(folder.path() / "Frame_1.txt", 3);
  ASSERT_TRUE(features);
  ASSERT_EQ(features->size(), 1U);
  EXPECT_EQ(features->at(0).id, 2);
  EXPECT_NEAR(features->at(0).u, 2150 * 0.1 + 648, 1e-6);
  EXPECT_NEAR(features->at(0).v, 2150 * -0.05 + 315, 1e-6);
}

TEST(OpenSrdResults, SavedFeaturesOfADialectComeBackInChronologicalOrder) {
  const ScratchFolder folder;
  for (int k = 0; k < 12; ++k) folder.write("RESULTS/FEATURES/CAM1/Frame_" + std::to_string(k) + ".txt", "");
  Settings s = two_cameras();
  s.dialect = Dialect::kGuide;
  const auto files = saved_features(folder.path(), s.cameras[0], 0, s);
  ASSERT_TRUE(files) << files.error().text();
  ASSERT_EQ(files->size(), 12U);
  EXPECT_EQ(files->front().filename(), "Frame_11.txt");
  EXPECT_EQ(files->back().filename(), "Frame_0.txt");
  std::filesystem::remove(folder.path() / "RESULTS/FEATURES/CAM1/Frame_3.txt");
  const auto gap = saved_features(folder.path(), s.cameras[0], 0, s);
  ASSERT_FALSE(gap);
  EXPECT_NE(gap.error().text().find("Frame_3.txt"), std::string::npos) << gap.error().text();
  EXPECT_FALSE(saved_features(folder.path(), s.cameras[1], 1, s));
}

TEST(OpenSrdResults, ImagesAreInNaturalOrder) {
  const ScratchFolder folder;
  for (const char* name : {"f10.png", "f9.PNG", "f100.bmp", "notes.txt", "f1.png"}) folder.write(name, "");
  std::vector<std::string> notes;
  const auto files = image_files(folder.path(), notes);
  ASSERT_TRUE(files);
  std::vector<std::string> names;
  for (const auto& file : *files) names.push_back(file.filename().string());
  EXPECT_EQ(names, (std::vector<std::string>{"f1.png", "f9.PNG", "f10.png", "f100.bmp"}));
}

}  // namespace
}  // namespace srd::host::opensrd
