// SPDX-License-Identifier: Apache-2.0
// srd reconstruct on OpenSRD folders whose features follow exactly from known surfaces.
#include <gtest/gtest.h>

#include "drivers/geometry/points.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

using fakes::coefficients;
using fakes::flume_scene;
using fakes::wavy;

// A surface of so many parameters that differs from frame to frame.
fakes::Coefficients<double> surface_at(int parameters, int frame, double level_mm = 80) {
  fakes::Coefficients<double> a = wavy(parameters, level_mm + 0.5 * frame);
  for (int j = 1; j < parameters; ++j) a[j] *= std::cos(0.4 * frame + j);
  return a;
}

void expect_surfaces(const OpenSrdFolder& lab, double within_mm) {
  const auto found = series_coefficients(lab.out() / "surface.csv", lab.scene.model.modes);
  ASSERT_EQ(found.size(), lab.truths.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_LT(surface_rms(lab.scene.model, lab.scene.points, found[i], lab.truths[i]), within_mm) << "frame " << i;
}

struct Case {
  int parameters, cameras;
  const char* metric;
};

class ReconstructExactly : public testing::TestWithParam<Case> {};

TEST_P(ReconstructExactly, TheTrueSurfacesFromTheirFeatures) {
  const Case& c = GetParam();
  OpenSrdFolder lab(flume_scene(c.parameters, c.cameras));
  lab.keys["Epsg"] = "1e-12";  // of OpenSRD's 1e-6 rad, collinearity would make 1e-4 mm
  for (int frame = 0; frame < 6; ++frame) lab.add_frame(surface_at(c.parameters, frame));
  const CommandResult done = lab.run({"--metric", c.metric, "--refractive-index", "1.333"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.err, "");
  expect_surfaces(lab, 2e-5);  // the series has 6 decimals
}

INSTANTIATE_TEST_SUITE_P(Reconstruct, ReconstructExactly,
                         testing::Values(Case{1, 1, "disparity"}, Case{3, 1, "collinearity"}, Case{5, 1, "disparity"},
                                         Case{5, 2, "collinearity"}, Case{8, 1, "reprojection"}, Case{8, 3, "disparity"},
                                         Case{12, 1, "disparity"}, Case{12, 2, "reprojection"}, Case{12, 3, "collinearity"}));

TEST(Reconstruct, FindsShallowWaterFromAGuessFarOff) {
  // OpenSRD's collinearity ends at a wrong depth from such a start, and its 12 parameters lack a factor.
  for (const char* metric : {"collinearity", "disparity"})
    for (const double guess_mm : {1.0, 70.0, 200.0}) {
      OpenSrdFolder lab(flume_scene(12, 1), guess_mm);
      fakes::Coefficients<double> shallow = 0.15 * wavy(12);
      shallow[0] = 5.6;
      lab.add_frame(shallow);
      const CommandResult done = lab.run({"--metric", metric, "--refractive-index", "1.333"});
      ASSERT_EQ(done.exit, 0) << done.err;
      expect_surfaces(lab, 2e-5);
    }
}

TEST(Reconstruct, UsesTheIndexOfBothPublishedCodesUnlessToldAndAlwaysSaysWhich) {
  fakes::Scene scene = flume_scene(5, 1);
  scene.media.water = 1.336;
  OpenSrdFolder lab(scene);
  lab.add_frame(surface_at(5, 0));
  const CommandResult done = lab.run();
  ASSERT_EQ(done.exit, 0) << done.err;
  expect_surfaces(lab, 2e-5);
  EXPECT_NE(done.out.find("refractive index 1.336"), std::string::npos) << done.out;
  EXPECT_NE(lab.result("summary.txt").find("refractive index: 1.336"), std::string::npos);
  EXPECT_NE(lab.result("surface.csv.model.toml").find("refractive_index = 1.336"), std::string::npos);
  ASSERT_EQ(lab.run({"--force", "--refractive-index", "1.33"}).exit, 0);
  EXPECT_NE(lab.result("summary.txt").find("refractive index: 1.33 "), std::string::npos);
}

TEST(Reconstruct, EstimatesTheIndexOfWaterAndStatesItWithItsDeviation) {
  OpenSrdFolder lab(flume_scene(5, 3));  // water of 1.333
  for (int frame = 0; frame < 4; ++frame) lab.add_frame(surface_at(5, frame));
  const CommandResult done = lab.run({"--free-index", "--metric", "reprojection"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.err, "");
  expect_surfaces(lab, 1e-4);
  EXPECT_NE(done.out.find("refractive index 1.333000 +- "), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("estimated in 4 frames"), std::string::npos) << done.out;
  EXPECT_NE(lab.result("summary.txt").find("refractive index: 1.333000 +- "), std::string::npos);
  EXPECT_NE(lab.result("summary.txt").find("index\tits deviation"), std::string::npos);
  EXPECT_NE(lab.result("surface.csv.model.toml").find("refractive_index = 1.33"), std::string::npos);
}

TEST(Reconstruct, RefusesAnIndexThatTheViewCannotTellFromTheHeight) {
  fakes::Scene scene = flume_scene(5, 1);
  scene.views[0] = fakes::look_at(fakes::flume_camera(), {100, 200, 950}, {100, 200, 0});
  OpenSrdFolder lab(scene);
  lab.add_frame(fakes::level(5, 80));
  const CommandResult done = lab.run({"--free-index", "--metric", "reprojection"});
  EXPECT_EQ(done.exit, 3);
  EXPECT_NE(done.err.find("separate the index of water from A00"), std::string::npos) << done.err;
  EXPECT_EQ(lab.run({"--force", "--refractive-index", "1.333"}).exit, 0);
  const CommandResult outside = lab.run({"--force", "--free-index", "--refractive-index", "1.5"});
  EXPECT_EQ(outside.exit, 2);
  EXPECT_NE(outside.err.find("1.3 to 1.4"), std::string::npos) << outside.err;
}

TEST(Reconstruct, NamesTheModesThatTheViewCannotSeparate) {
  OpenSrdFolder lab(flume_scene(5, 1));
  lab.keys["Lx"] = "90000";
  lab.add_frame(fakes::level(5, 80));
  const CommandResult done = lab.run({"--refractive-index", "1.333"});
  EXPECT_EQ(done.exit, 3);
  EXPECT_NE(done.err.find("1 of 1 frames: no surface: the view cannot separate A10 from A00"), std::string::npos) << done.err;
}

TEST(Reconstruct, FilesStartAtTheLastFrameAndTheSeriesAtTheFirst) {
  OpenSrdFolder lab(flume_scene(3, 1));
  for (int frame = 0; frame < 12; ++frame) lab.add_frame(surface_at(3, frame), 0.05, static_cast<unsigned>(frame));
  ASSERT_EQ(lab.run({"--refractive-index", "1.333", "--rate", "50"}).exit, 0);
  const auto lines = coefficient_lines(lab.result("Coefficients.txt"));
  const auto series = series_coefficients(lab.out() / "surface.csv", lab.scene.model.modes);
  const std::string errors_file = lab.result("Errors.txt");  // its lines are views of it
  const auto errors = split_lines(errors_file);
  const auto table = CsvTable::read(lab.out() / "surface.csv");
  ASSERT_TRUE(table);
  ASSERT_EQ(lines.size(), 12U);
  ASSERT_EQ(series.size(), 12U);
  ASSERT_EQ(errors.size(), 12U);
  const auto mean_errors = table->numbers("mean_error");
  const auto times = table->integers("time_ns");
  ASSERT_TRUE(mean_errors && times);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_LT((lines[i] - series[11 - i]).norm(), 2e-5);
    EXPECT_LT(surface_rms(lab.scene.model, lab.scene.points, series[i], lab.truths[i]), 0.2);
    EXPECT_NEAR(*parse_number<double>(errors[i].text), (*mean_errors)[11 - i], 1e-6);
    EXPECT_EQ((*times)[i], static_cast<std::int64_t>(i) * 20'000'000);
  }
}

TEST(Reconstruct, ErrorsAreThoseOfTheirOwnFrame) {
  // OpenSRD adds up the errors of all frames before: the same noise in every frame must give the same error.
  OpenSrdFolder lab(flume_scene(5, 1));
  for (int frame = 0; frame < 8; ++frame) lab.add_frame(surface_at(5, 1), 0.1, 7);
  ASSERT_EQ(lab.run({"--refractive-index", "1.333"}).exit, 0);
  const std::string text = lab.result("Errors.txt");
  const auto errors = split_lines(text);
  ASSERT_EQ(errors.size(), 8U);
  const double first = *parse_number<double>(errors[0].text);
  // 0.1 px an axis is 0.045 mm an axis here; the mean of its length is sqrt(pi/2) of that.
  EXPECT_NEAR(first, 0.045 * std::sqrt(fakes::kPi / 2), 0.01);
  for (const TextLine& line : errors) EXPECT_NEAR(*parse_number<double>(line.text), first, 1e-6);
}

TEST(Reconstruct, EveryCameraUsesItsOwnFramesPointsAndCalibration) {
  // OpenSRD reads camera 1's frames for camera 2. Here no two cameras share a list: each has its own order of points.
  fakes::Scene scene = flume_scene(8, 3);
  scene.views[1].camera = dsp::CameraModel<double>::make(2300, 2310, 630, 330, {}).value();
  OpenSrdFolder lab(scene);
  for (int frame = 0; frame < 5; ++frame) lab.add_frame(surface_at(8, frame));
  std::mt19937 random(5);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<std::size_t> order(lab.scene.points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    Points listed(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) listed[order[i]] = lab.scene.points[i];
    ASSERT_TRUE(write_points(lab.path() / "INPUT" / ("FeaturesF_" + std::to_string(c + 1) + ".txt"), listed));
    for (std::size_t frame = 0; frame < 5; ++frame) {
      const std::string name = OpenSrdFolder::feature_file(c, frame);
      const std::string text = fakes::bytes_of(lab.path() / name);
      std::string renumbered;
      for (const TextLine& line : split_lines(text)) {
        const auto fields = split_blanks(line.text);
        renumbered += std::to_string(order[*parse_number<std::size_t>(fields[0])]) + " " + std::string(fields[1]) + " " +
                      std::string(fields[2]) + "\n";
      }
      lab.write(name, renumbered);
    }
  }
  const CommandResult done = lab.run({"--refractive-index", "1.333"});
  ASSERT_EQ(done.exit, 0) << done.err;
  expect_surfaces(lab, 2e-5);
}

TEST(Reconstruct, EveryFrameIsProcessedAndThreadsChangeNothing) {
  // OpenSRD drops the frames beyond a multiple of its threads.
  OpenSrdFolder lab(flume_scene(5, 2));
  for (int frame = 0; frame < 7; ++frame) lab.add_frame(surface_at(5, frame), 0.1, static_cast<unsigned>(frame));
  std::vector<std::string> series;
  for (const char* threads : {"1", "2", "3"}) {
    lab.keys["ThreadAmount"] = threads;
    const CommandResult done = lab.run({"--force", "--threads", threads});
    ASSERT_EQ(done.exit, 0) << done.err;
    series.push_back(lab.result("surface.csv") + lab.result("Coefficients.txt") + lab.result("Errors.txt"));
  }
  EXPECT_EQ(split_lines(lab.result("Coefficients.txt")).size(), 7U);
  EXPECT_EQ(series[1], series[0]);
  EXPECT_EQ(series[2], series[0]);
}

TEST(Reconstruct, ScalingIsUsedByTheStepsAndLeavesTheOptimum) {
  OpenSrdFolder lab(flume_scene(5, 1));
  lab.add_frame(surface_at(5, 0), 0.1);
  ASSERT_EQ(lab.run({"--refractive-index", "1.333"}).exit, 0);
  const auto plain = series_coefficients(lab.out() / "surface.csv", lab.scene.model.modes);
  lab.keys["Scaling"] = "\"[10,0.1,0.1,5,5]\"";
  ASSERT_EQ(lab.run({"--refractive-index", "1.333", "--force"}).exit, 0);
  const auto scaled = series_coefficients(lab.out() / "surface.csv", lab.scene.model.modes);
  EXPECT_LT((plain[0] - scaled[0]).norm(), 1e-3);
}

TEST(Reconstruct, FeaturesCountedFromTheListsEndAreReadSo) {
  // As OpenSRD counts for a camera on the other side of the pattern.
  OpenSrdFolder lab(flume_scene(5, 2));
  for (int frame = 0; frame < 3; ++frame) lab.add_frame(surface_at(5, frame));
  for (std::size_t frame = 0; frame < 3; ++frame) {
    const std::string name = OpenSrdFolder::feature_file(1, frame), text = fakes::bytes_of(lab.path() / name);
    std::string turned;
    for (const TextLine& line : split_lines(text)) {
      const auto fields = split_blanks(line.text);
      turned += std::to_string(230 - *parse_number<int>(fields[0])) + " " + std::string(fields[1]) + " " +
                std::string(fields[2]) + "\n";
    }
    lab.write(name, turned);
  }
  const CommandResult done = lab.run({"--refractive-index", "1.333"});
  ASSERT_EQ(done.exit, 0) << done.err;
  expect_surfaces(lab, 2e-5);
  EXPECT_NE(done.err.find("camera 2: the features' ids count from the points' end"), std::string::npos) << done.err;
}

TEST(Reconstruct, UnequalNumbersOfFramesUseTheCommonOnesAndSayWhich) {
  OpenSrdFolder lab(flume_scene(3, 2));
  for (int frame = 0; frame < 5; ++frame) lab.add_frame(surface_at(3, frame));
  std::filesystem::remove(lab.path() / OpenSrdFolder::feature_file(1, 4));
  lab.truths.pop_back();
  const CommandResult done = lab.run({"--refractive-index", "1.333"});
  ASSERT_EQ(done.exit, 0) << done.err;
  expect_surfaces(lab, 2e-5);
  for (const char* part : {"camera 1 5, camera 2 4", "first 4", "f0003.txt"})
    EXPECT_NE(done.err.find(part), std::string::npos) << done.err;
  EXPECT_NE(lab.result("summary.txt").find("camera 1 5, camera 2 4"), std::string::npos);
}

TEST(Reconstruct, HiddenFeaturesCostOnlyThemselvesAndAnEmptyFrameOnlyItself) {
  OpenSrdFolder lab(flume_scene(5, 1));
  for (int frame = 0; frame < 6; ++frame) lab.add_frame(surface_at(5, frame));
  const std::string half = fakes::bytes_of(lab.path() / OpenSrdFolder::feature_file(0, 2));
  lab.write(OpenSrdFolder::feature_file(0, 2), half.substr(0, half.find("\n120\t") + 1));
  lab.write(OpenSrdFolder::feature_file(0, 3), "");
  const CommandResult done = lab.run({"--refractive-index", "1.333"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto found = series_coefficients(lab.out() / "surface.csv", lab.scene.model.modes);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_TRUE(std::isnan(found[3][0]));
  for (const std::size_t i : {0U, 1U, 2U, 4U, 5U})
    EXPECT_LT(surface_rms(lab.scene.model, lab.scene.points, found[i], lab.truths[i]), 1e-4) << i;
  EXPECT_EQ(split_lines(lab.result("Coefficients.txt"))[2].text, "[nan,nan,nan,nan,nan]");
  EXPECT_NE(lab.result("surface.csv").find("too_few_corners,231,0,0,,disparity,,"), std::string::npos);
}

TEST(Reconstruct, ResultsAreNotOverwrittenUnlessForced) {
  OpenSrdFolder lab(flume_scene(3, 1));
  lab.add_frame(surface_at(3, 0));
  ASSERT_EQ(lab.run().exit, 0);
  const std::string before = lab.result("summary.txt");
  lab.write(OpenSrdFolder::feature_file(0, 0), "damaged");  // refused before anything is read
  const CommandResult again = lab.run();
  EXPECT_EQ(again.exit, 2);
  EXPECT_NE(again.err.find("--force"), std::string::npos) << again.err;
  EXPECT_EQ(lab.run({"--force"}).exit, 3);
  EXPECT_EQ(lab.result("summary.txt"), before);
}

}  // namespace
}  // namespace srd::host
