// SPDX-License-Identifier: Apache-2.0
// srd reconstruct on the lab's recordings and on rendered cases with known truth. BARS: data/opensrd-2016, p1, p2.
#include <gtest/gtest.h>

#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "host/opensrd/reconstruction.hpp"
#include "host/run/series.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

class ReconstructLab : public testing::Test {
 protected:
  void SetUp() override {
    const auto root = lab_data();
    if (!root) GTEST_SKIP() << "no lab recordings: set SRD_DATA to their folder";
    data = *root;
  }
  // The settings of a case, some keys changed, beside links to its folders.
  fs::path settings(const std::string& name, const std::map<std::string, std::string>& changes) const {
    for (const auto& entry : fs::directory_iterator(data / name))
      if (entry.is_directory() && !fs::exists(folder.path() / entry.path().filename()))
        fs::create_directory_symlink(entry.path(), folder.path() / entry.path().filename());
    std::string text = fakes::bytes_of(data / name / "settings.xml");
    for (const auto& [key, value] : changes) {
      const std::size_t at = text.find("<" + key + ">") + key.size() + 2;
      text.replace(at, text.find("</" + key + ">") - at, value);
    }
    return folder.write("settings.xml", text);
  }
  [[nodiscard]] CommandResult reconstruct(const fs::path& source, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {source.string(), "--out", (folder.path() / "out").string(), "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }
  [[nodiscard]] std::string result(const std::string& name) const { return fakes::bytes_of(folder.path() / "out" / name); }

  // Mean over the file's lines, and of the surfaces' heights over the points.
  struct Figures {
    double error = 0, height = 0;
    std::size_t frames = 0;
  };
  [[nodiscard]] Figures figures_2016() const {
    Figures f;
    const std::string errors = result("Errors.txt");
    for (const TextLine& line : split_lines(errors)) f.error += parse_number<double>(line.text).value_or(std::nan(""));
    const auto surfaces = coefficient_lines(result("Coefficients.txt"));
    const auto points = read_points(data / "opensrd-2016/INPUT/FeaturesF_1.txt");
    const dsp::SurfaceModel<double> model{dsp::ModeList::standard(5).value(), 40, 160, 0, 0};
    for (const auto& a : surfaces)
      for (const auto& p : *points) f.height += model.height(a, p.x(), p.y()) / static_cast<double>(points->size());
    f.frames = surfaces.size();
    f.error /= static_cast<double>(f.frames);
    f.height /= static_cast<double>(f.frames);
    return f;
  }
  // rms over points and frames of the series against truth.csv, mm.
  [[nodiscard]] double rms_against_truth(const std::string& name, int parameters) const {
    const auto truth = coefficient_lines(fakes::bytes_of(data / name / "truth.csv"));
    const dsp::SurfaceModel<double> model{dsp::ModeList::standard(parameters).value(), 240, 440, 0, 0};
    const auto found = series_coefficients(folder.path() / "out/surface.csv", model.modes);
    const auto points = read_points(data / name / "PRE_PROCESS/FeaturesF.txt");
    EXPECT_EQ(found.size(), truth.size());
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += std::pow(surface_rms(model, *points, found.at(i), truth[i]), 2);
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }

  fs::path data;
  fakes::ScratchFolder folder;
};

TEST_F(ReconstructLab, PublishedFeaturesGiveTheLeastSquaresOptimum) {
  const auto file = settings("opensrd-2016", {{"TypeCameraPose", "0"}, {"InputReference1", "\"Camera_Pose_1.txt\""}});
  const CommandResult done = reconstruct(file, {"--features", (data / "opensrd-2016/published").string()});
  ASSERT_EQ(done.exit, 0) << done.err;
  const Figures f = figures_2016();
  EXPECT_EQ(f.frames, 1U);
  EXPECT_NEAR(f.error, 0.0967, 0.0001);
  EXPECT_NEAR(f.height, 5.574, 0.002);
}

TEST_F(ReconstructLab, ImagesOf2016) {
  const CommandResult done = reconstruct(settings("opensrd-2016", {}));
  ASSERT_EQ(done.exit, 0) << done.err;
  const Figures f = figures_2016();
  EXPECT_EQ(f.frames, 3U);
  EXPECT_LE(f.error, 0.0985);
  EXPECT_NEAR(f.height, 5.574, 0.035);
  EXPECT_TRUE(fs::exists(folder.path() / "out/FEATURES_1/Frame_2.txt"));
}

TEST_F(ReconstructLab, TwelveParametersReachTheSameDepth) {
  const auto file = settings("opensrd-2016", {{"SurfaceModelParameters", "12"}, {"Scaling", list_text(12, 1, 1)}});
  const CommandResult done = reconstruct(file);
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto prepared = opensrd::prepare(*opensrd::read_settings(file), {});
  ASSERT_TRUE(prepared);
  for (const auto& a : coefficient_lines(result("Coefficients.txt")))
    EXPECT_NEAR(pattern_height(prepared->plan, a), 5.574, 0.05);
}

TEST_F(ReconstructLab, SavedFeaturesGiveTheSameCoefficientsAsTheirImages) {
  for (const char* name : {"opensrd-2016", "rendered/p1_5term"}) {
    const fakes::ScratchFolder again;
    const std::string file = (data / name / "settings.xml").string();
    ASSERT_EQ(reconstruct(file).exit, 0);
    const CommandResult second =
        run_command({file, "--out", again.path().string(), "--features", (folder.path() / "out").string()});
    ASSERT_EQ(second.exit, 0) << second.err;
    EXPECT_EQ(second.err, "");
    const int parameters = 5;
    const auto modes = dsp::ModeList::standard(parameters).value();
    const auto images = series_coefficients(folder.path() / "out/surface.csv", modes);
    const auto features = series_coefficients(again.path() / "surface.csv", modes);
    ASSERT_EQ(images.size(), features.size());
    for (std::size_t i = 0; i < images.size(); ++i) EXPECT_LT((images[i] - features[i]).norm(), 1e-3) << name << " " << i;
    fs::remove_all(folder.path() / "out");
  }
}

TEST_F(ReconstructLab, PosesOfTheReferenceImages) {
  struct Expected {
    const char* name;
    std::vector<const char*> poses;
    double centre_mm, radians, projected_px;
  };
  for (const Expected& expected :
       {Expected{"opensrd-2016", {"published/Camera_Pose_1.txt"}, 0.3, 1e-3, 0.1},
        Expected{"rendered/p1_5term", {"truth_pose_1.yml"}, 0.1, 1e-4, 0.02},
        Expected{"rendered/p2_8term_2cam", {"truth_pose_1.yml", "truth_pose_2.yml"}, 0.1, 1e-4, 0.02}}) {
    const auto prepared = opensrd::prepare(*opensrd::read_settings(data / expected.name / "settings.xml"), {});
    ASSERT_TRUE(prepared) << prepared.error().text();
    for (std::size_t c = 0; c < expected.poses.size(); ++c) {
      const auto truth = read_pose(data / expected.name / expected.poses[c]);
      ASSERT_TRUE(truth);
      const RunCamera& camera = prepared->plan.cameras.at(c);
      EXPECT_LT((camera.pose.centre() - truth->centre()).norm(), expected.centre_mm) << expected.name;
      EXPECT_LT((camera.pose.translation - truth->translation).norm(), expected.centre_mm) << expected.name;
      EXPECT_LT((camera.pose.rotation - truth->rotation).norm() / std::sqrt(2), expected.radians) << expected.name;
      const dsp::View<double> ours{camera.calibration.camera, camera.pose}, theirs{camera.calibration.camera, *truth};
      double sum = 0;
      for (const auto& p : prepared->plan.points)
        sum += (camera.calibration.camera.pixel(*ours.normalised(p)) - camera.calibration.camera.pixel(*theirs.normalised(p)))
                   .squaredNorm();
      EXPECT_LT(std::sqrt(sum / static_cast<double>(prepared->plan.points.size())), expected.projected_px) << expected.name;
    }
  }
}

TEST_F(ReconstructLab, RenderedOneCamera) {
  const CommandResult done = reconstruct(data / "rendered/p1_5term/settings.xml");
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_LE(rms_against_truth("rendered/p1_5term", 5), 0.06);
  // The guide's order: the first line is the last frame.
  const auto lines = coefficient_lines(result("RESULTS/Coefficients.txt"));
  const auto truth = coefficient_lines(fakes::bytes_of(data / "rendered/p1_5term/truth.csv"));
  ASSERT_EQ(lines.size(), truth.size());
  EXPECT_LT((lines.front() - truth.back()).norm(), 0.1);
  EXPECT_GT((lines.front() - truth.front()).norm(), 1);
}

TEST_F(ReconstructLab, RenderedTwoCamerasFromBothSides) {
  const CommandResult done = reconstruct(data / "rendered/p2_8term_2cam");  // the folder will do
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_LE(rms_against_truth("rendered/p2_8term_2cam", 8), 0.03);
  EXPECT_TRUE(fs::exists(folder.path() / "out/RESULTS/FEATURES/CAM2/Frame_7.txt"));
}

TEST_F(ReconstructLab, RenderedFramesAsARecording) {
  const fs::path source = data / "rendered/p1_5term";
  fs::create_directory(folder.path() / "recording");
  for (const auto& entry : fs::directory_iterator(source / "DATA/CAM1"))
    fs::create_symlink(entry.path(), folder.path() / "recording" / entry.path().filename());
  fs::create_symlink(source / "PRE_PROCESS/Calib_CAM1.yml", folder.path() / "recording/calibration.yml");
  fs::create_symlink(source / "PRE_PROCESS/FeaturesF.txt", folder.path() / "recording/points.txt");
  fs::create_symlink(source / "truth_pose_1.yml", folder.path() / "recording/pose.yml");
  const CommandResult done = reconstruct(folder.path() / "recording", {"--model", "5", "--lx", "240", "--ly", "440", "--guess",
                                                                       "80", "--refractive-index", "1.336", "--rate", "50"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.err, "");
  EXPECT_LE(rms_against_truth("rendered/p1_5term", 5), 0.06);
}

TEST_F(ReconstructLab, PatchOf2017AgreesWithItsPublishedSeries) {
  const CommandResult done = reconstruct(data / "opensrd-2017/settings.xml", {"--threads", "2"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto ours = coefficient_lines(result("RESULTS/TimeSeries_CAM1.txt"));
  const auto theirs = coefficient_lines(fakes::bytes_of(data / "opensrd-2017/published/TimeSeries_CAM1_first500.txt"));
  ASSERT_EQ(theirs.size(), 500U);
  ASSERT_EQ(ours.size(), theirs.size());
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0, squares = 0;
  for (std::size_t k = 0; k < ours.size(); ++k) {
    const double a = ours[k][0], b = theirs[k][0];
    ASSERT_TRUE(std::isfinite(a)) << k;
    n += 1, x += a, y += b, xx += a * a, yy += b * b, xy += a * b, squares += (a - b) * (a - b);
  }
  EXPECT_LE(std::sqrt(squares / n), 0.35);
  EXPECT_GE((xy - x * y / n) / std::sqrt((xx - x * x / n) * (yy - y * y / n)), 0.99);
  // The pose is that of the published run: another program's corners, the same image.
  const auto published = read_pose(data / "opensrd-2017/published/Camera_Pose_1.txt");
  const auto pose = read_pose(folder.path() / "out/RESULTS/Camera_Pose_1.txt");
  ASSERT_TRUE(published && pose);
  EXPECT_LT((pose->centre() - published->centre()).norm(), 1);
}

TEST_F(ReconstructLab, ThreadsChangeNothingOnImages) {
  std::vector<std::string> results;
  for (const char* threads : {"1", "2", "3"}) {
    ASSERT_EQ(reconstruct(data / "rendered/p2_8term_2cam", {"--threads", threads}).exit, 0);
    results.push_back(result("surface.csv") + result("RESULTS/Coefficients.txt") + result("RESULTS/FEATURES/CAM2/Frame_7.txt"));
  }
  EXPECT_EQ(results[1], results[0]);
  EXPECT_EQ(results[2], results[0]);
}

}  // namespace
}  // namespace srd::host
