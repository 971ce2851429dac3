// SPDX-License-Identifier: Apache-2.0
// srd reconstruct on settings of OpenSRD's 2017 release: the pattern metric on a region of rendered images.
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/opensrd/patch_run.hpp"
#include "host/run/ordered_work.hpp"
#include "host/run/pattern_mask.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

// A flume at half its resolution, under a plane that rises, falls and leans, as the 2017 release's folder.
class Release2017 {
 public:
  explicit Release2017(int frames) {
    srd::Scene scene = default_scene();
    const auto& camera = scene.calibration.camera;
    scene.calibration.camera =
        dsp::CameraModel<double>::make(camera.fx() / 2, camera.fy() / 2, camera.cx() / 2, camera.cy() / 2, camera.distortion())
            .value();
    scene.calibration.image_width /= 2;
    scene.calibration.image_height /= 2;
    scene.frames = frames;
    scene.surface = {dsp::ModeList::standard(3).value(), 100, 100, 100, 200};
    scene.motions = {
        {*dsp::Mode::parse("A00"), 80, 3, 2, 0}, {*dsp::Mode::parse("B"), 0, 2, 3, 1}, {*dsp::Mode::parse("C"), -7, 0, 0, 0}};
    scene.media.water = opensrd::kPublishedIndex;
    scene_ = scene;
    fs::create_directories(folder_.path() / "INPUT");
    const PixelCentre middle = write_images(scene, "INPUT/Reference.png", "DATA");
    const int u = middle.u, v = middle.v;
    EXPECT_TRUE(write_calibration(folder_.path() / "INPUT/Calib.yml", scene.calibration));
    // Column by column from the image's left, each from the bottom; and only inner corners.
    const Points rows = scene.points();
    const int n_rows = scene.pattern.rows, n_columns = scene.pattern.columns;
    Points listed;
    for (int column = 0; column < n_columns; ++column)
      for (int row = n_rows - 1; row >= 0; --row) listed.push_back(rows[static_cast<std::size_t>(row * n_columns + column)]);
    EXPECT_TRUE(write_points(folder_.path() / "INPUT/Vertices.txt", listed));
    keys = {{"NumberOfCameras", "1"},
            {"TypeCameraPose", "1"},
            {"InputDirectory1", quoted("DATA")},
            {"InputInitial1", quoted("INPUT/Vertices.txt")},
            {"InputReference1", quoted("INPUT/Reference.png")},
            {"CalibrationFile1", quoted("INPUT/Calib.yml")},
            {"OutputCameraPose1", quoted("RESULTS/Pose.txt")},
            {"OutputFileName", quoted("RESULTS/Series.txt")},
            {"OutputFileCenters", quoted("RESULTS/Centers.txt")},
            {"Lx", "100"},
            {"Ly", "100"},
            {"RefPatternSize_Width", std::to_string(n_rows)},
            {"RefPatternSize_Height", std::to_string(n_columns)},
            {"gridSize", "20"},
            {"MinDistance", "8"},
            {"ResponseRadius", "5"},
            {"ResponseThreshold", "350"},
            {"min_u", std::to_string(u - 60)},
            {"max_u", std::to_string(u + 55)},
            {"min_v", std::to_string(v - 45)},
            {"max_v", std::to_string(v + 50)},
            {"minThreshold", "90"},
            {"maxThreshold", "95"},
            {"Epsg", "0"},
            {"Epsf", "0"},
            {"Epsx", "0"},
            {"MaxIts", "0"},
            {"InitialGuess", quoted("[77.0,0.5]")},
            {"SurfaceModelParameters", "3"},
            {"Scaling", quoted("[1.0,1.0]")}};
  }

  // On the opposite side: half a turn about the pattern's middle. Its list of points begins at what is its image's lower left.
  void add_second_camera() {
    srd::Scene scene = scene_;
    const dsp::Vec3<double> half_turn(-1, -1, 1);
    const Points points = scene.points();
    const dsp::Vec3<double> middle = (points.front() + points.back()) / 2;
    scene.pose.rotation = scene_.pose.rotation * half_turn.asDiagonal();
    scene.pose.translation += scene_.pose.rotation * (middle - half_turn.asDiagonal() * middle);
    const PixelCentre at = write_images(scene, "INPUT/Reference2.png", "DATA2");
    Points listed = read_points(folder_.path() / "INPUT/Vertices.txt").value();
    std::reverse(listed.begin(), listed.end());
    EXPECT_TRUE(write_points(folder_.path() / "INPUT/Vertices2.txt", listed));
    keys.merge(Keys{{"InputDirectory2", quoted("DATA2")},
                    {"InputInitial2", quoted("INPUT/Vertices2.txt")},
                    {"InputReference2", quoted("INPUT/Reference2.png")},
                    {"CalibrationFile2", quoted("INPUT/Calib.yml")},
                    {"OutputCameraPose2", quoted("RESULTS/Pose2.txt")},
                    {"min_u2", std::to_string(at.u - 60)},
                    {"max_u2", std::to_string(at.u + 55)},
                    {"min_v2", std::to_string(at.v - 45)},
                    {"max_v2", std::to_string(at.v + 50)}});
    keys["NumberOfCameras"] = "2";
  }
  [[nodiscard]] CommandResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {folder_.write("settings.xml", settings_text(keys)).string(), "--out", out().string(),
                                          "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }
  [[nodiscard]] const fs::path& path() const { return folder_.path(); }
  [[nodiscard]] std::string result(const std::string& name) const { return fakes::bytes_of(out() / name); }
  [[nodiscard]] const srd::Scene& scene() const { return scene_; }
  // The true surface's height at (X, Y).
  [[nodiscard]] double height(std::size_t frame, double x, double y) const {
    return scene_.surface.height(scene_.coefficients(frame), x, y);
  }

  Keys keys;

 private:
  struct PixelCentre {
    int u = 0, v = 0;
  };
  // A reference and frames that show 70 x 60 px of the pattern; where their middle lies.
  PixelCentre write_images(const srd::Scene& scene, const std::string& reference, const std::string& frames) const {
    Renderer renderer = Renderer::make(scene).value();
    GrayImage image;
    image.width = scene.width();
    image.height = scene.height();
    image.pixels.resize(static_cast<std::size_t>(image.width * image.height));
    const GrayBuffer buffer{image.pixels.data(), image.width, image.height, image.width};
    fs::create_directories(folder_.path() / frames);
    renderer.render_reference(buffer);
    EXPECT_TRUE(write_gray_image(folder_.path() / reference, image.view(), 1));
    const auto middle = truth_pixels(scene, 0).value()[static_cast<std::size_t>(5 * scene.pattern.columns + 10)];
    const int u = static_cast<int>(middle.x()), v = static_cast<int>(middle.y());
    for (int frame = 0; frame < scene.frames; ++frame) {
      renderer.render(static_cast<std::uint64_t>(frame), buffer);
      for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column)
          if (column < u - 35 || column >= u + 35 || row < v - 30 || row >= v + 30)
            image.pixels[static_cast<std::size_t>(row * image.width + column)] = 94;
      const std::string digits = std::to_string(frame);
      EXPECT_TRUE(write_gray_image(folder_.path() / frames / ("Proc" + std::string(4 - digits.size(), '0') + digits + ".png"),
                                   image.view(), 1));
    }
    return {u, v};
  }

  srd::Scene scene_;
  fakes::ScratchFolder folder_;
};

// A plane in the modes' own form, by one patch, by two, and what each says of its error.
TEST(Reconstruct2017, TwoCamerasMeasureOneSurfaceTogether) {
  Release2017 lab(8);
  lab.keys["InitialGuess"] = quoted("[78.0,0.0,-7.0]");
  lab.keys["Scaling"] = quoted("[1.0,1.0,1.0]");
  const auto error = [&](std::vector<double>& worst) {
    const CommandResult done = lab.run();
    ASSERT_EQ(done.exit, 0) << done.err;
    const auto lines = coefficient_lines(lab.result("RESULTS/Series.txt"));
    const auto centres = coefficient_lines(lab.result("RESULTS/Centers.txt"));
    ASSERT_EQ(lines.size(), 8U);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      ASSERT_EQ(lines[k].size(), 3);
      for (int i = 0; i < 3; ++i)
        worst[static_cast<std::size_t>(i)] =
            std::max(worst[static_cast<std::size_t>(i)], i == 0 ? 0.0 : std::abs(lines[k][i] - lab.scene().coefficients(k)[i]));
    }
  };
  std::vector<double> one(3, 0.0), both(3, 0.0);
  error(one);
  lab.add_second_camera();
  error(both);
  std::printf("one %g %g both %g %g\n", one[1], one[2], both[1], both[2]);
  EXPECT_LT(both[1], one[1]);
  EXPECT_LT(both[2], one[2]);
}

TEST(Reconstruct2017, ASecondCameraOfAnotherBoardIsTold) {
  Release2017 lab(2);
  lab.add_second_camera();
  Points shifted = read_points(lab.path() / "INPUT/Vertices2.txt").value();
  for (auto& point : shifted) point.x() += 7;
  EXPECT_TRUE(write_points(lab.path() / "INPUT/Shifted.txt", shifted));
  lab.keys["InputInitial2"] = quoted("INPUT/Shifted.txt");
  const CommandResult done = lab.run();
  EXPECT_EQ(done.exit, static_cast<int>(Exit::kInput));
  EXPECT_NE(done.err.find("Reference2.png"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("first camera's"), std::string::npos) << done.err;
  fs::remove(lab.path() / "DATA2/Proc0001.png");
  lab.keys["InputInitial2"] = quoted("INPUT/Vertices2.txt");
  EXPECT_NE(lab.run().err.find("another number of images"), std::string::npos);
}

TEST(Reconstruct2017, FollowsTheLevelOfRenderedFramesInForwardOrder) {
  const Release2017 lab(30);
  const CommandResult done = lab.run();
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_NE(done.err.find("SurfaceModelParameters"), std::string::npos) << done.err;  // 3, with a guess of 2
  EXPECT_NE(done.out.find("level-normal"), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("refractive index 1.336"), std::string::npos) << done.out;
  const auto lines = coefficient_lines(lab.result("RESULTS/Series.txt"));
  const auto centres = coefficient_lines(lab.result("RESULTS/Centers.txt"));
  ASSERT_EQ(lines.size(), 30U);
  ASSERT_EQ(centres.size(), 30U);
  // The form's own slope along Y is the plane's here, so its level is the height where the region is seen, as far as the
  // form goes: it takes the surface for level where the rays meet it, which leaves up to 1.4 mm and 0.6 (over 100 mm).
  for (std::size_t k = 0; k < lines.size(); ++k) {
    ASSERT_EQ(lines[k].size(), 2);
    EXPECT_NEAR(lines[k][0], lab.height(k, centres[k][0], centres[k][1]), 2) << k;
    EXPECT_NEAR(lines[k][1], lab.scene().coefficients(k)[1], 1) << k;
  }
  EXPECT_TRUE(fs::exists(lab.out() / "RESULTS/Pose.txt"));
  EXPECT_NE(lab.result("surface.csv").find(",pattern,"), std::string::npos);
}

TEST(Reconstruct2017, APlaneIsFittedWithDeviationsThatCoverItsError) {
  const Release2017 lab(8);
  const CommandResult done = lab.run({"--model", "plane"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const auto lines = coefficient_lines(lab.result("RESULTS/Series.txt"));
  const auto models = read_model_file(lab.out() / "surface.csv.model.toml");
  ASSERT_TRUE(models) << models.error().text();
  const auto& model = models->nodes.at(0).model;
  const auto table = CsvTable::read(lab.out() / "surface.csv");
  ASSERT_TRUE(table);
  const auto deviations = table->numbers("sd_A00"), slopes = table->numbers("sd_B");
  ASSERT_TRUE(deviations && slopes);
  ASSERT_EQ(lines.size(), 8U);
  double level = 0, slope = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    ASSERT_EQ(lines[k].size(), 3);
    level += std::pow((lines[k][0] - lab.height(k, model.x0, model.y0)) / (*deviations)[k], 2) / 8;
    slope += std::pow((lines[k][1] - lab.scene().coefficients(k)[1]) / (*slopes)[k], 2) / 8;
  }
  // Chi square of 8 over 8 is below 3.3 with 99.9 %.
  EXPECT_LT(level, 6);
  EXPECT_LT(slope, 6);
}

TEST(Reconstruct2017, ThreadsChangeNothing) {
  const Release2017 lab(60);  // more than two blocks
  std::vector<std::string> results;
  for (const char* threads : {"1", "2", "3"}) {
    const CommandResult done = lab.run({"--threads", threads});
    ASSERT_EQ(done.exit, 0) << done.err;
    EXPECT_EQ(done.err.find("frame 1 of"), std::string::npos);  // no progress in a pipe
    results.push_back(lab.result("RESULTS/Series.txt") + lab.result("RESULTS/Centers.txt") + lab.result("surface.csv"));
  }
  EXPECT_EQ(split_lines(lab.result("RESULTS/Series.txt")).size(), 60U);
  EXPECT_EQ(results[1], results[0]);
  EXPECT_EQ(results[2], results[0]);
}

TEST(Reconstruct2017, ABlankFrameCostsOnlyItself) {
  const Release2017 lab(6);
  GrayImage blank;
  blank.width = lab.scene().width();
  blank.height = lab.scene().height();
  blank.pixels.assign(static_cast<std::size_t>(blank.width * blank.height), 94);
  ASSERT_TRUE(write_gray_image(lab.path() / "DATA/Proc0003.png", blank.view(), 1));
  ASSERT_TRUE(fs::exists(lab.path() / "DATA/Proc0004.png"));
  fs::resize_file(lab.path() / "DATA/Proc0004.png", 100);
  const CommandResult done = lab.run();
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_NE(done.err.find("Proc0004.png"), std::string::npos) << done.err;
  const auto lines = coefficient_lines(lab.result("RESULTS/Series.txt"));
  ASSERT_EQ(lines.size(), 6U);
  for (std::size_t k = 0; k < lines.size(); ++k) EXPECT_EQ(std::isnan(lines[k][0]), k == 3 || k == 4) << k;
  EXPECT_NE(lab.result("surface.csv").find("bad_frame"), std::string::npos);
}

TEST(Reconstruct2017, SaysWhatCannotBeDone) {
  Release2017 lab(1);
  EXPECT_NE(lab.run({"--metric", "disparity"}).err.find("--metric is for corners"), std::string::npos);
  EXPECT_NE(lab.run({"--features", "x"}).err.find("--features is for corners"), std::string::npos);
  const auto expect_problem = [&](const char* key, const std::string& value, int exit, const std::string& said) {
    const std::string before = lab.keys[key];
    lab.keys[key] = value;
    const CommandResult done = lab.run();
    EXPECT_EQ(done.exit, exit) << key;
    EXPECT_NE(done.err.find(said), std::string::npos) << done.err;
    lab.keys[key] = before;
  };
  expect_problem("gridSize", "10", 3, "gridSize");
  expect_problem("max_u", "2000", 2, "region");
  expect_problem("RefPatternSize_Width", "12", 3, "252");
  expect_problem("InitialGuess", quoted("[2000,0]"), 3, "InitialGuess");
  expect_problem("TypeCameraPose", "0", 2, "TypeCameraPose 1");
  EXPECT_FALSE(fs::exists(lab.out()));
}

TEST(PatternMask, LeavesOutWhatHangsTogetherWithTheBorderOnly) {
  // A blanked frame round 6 x 4 pixels; inside, an edge passes through the blanking grey.
  std::vector<std::uint8_t> pixels(10 * 8, 94);
  for (int v = 2; v < 6; ++v)
    for (int u = 2; u < 8; ++u) pixels[static_cast<std::size_t>(v * 10 + u)] = u < 5 ? 20 : 200;
  pixels[3 * 10 + 5] = 94;
  const auto mask = pattern_mask({pixels.data(), 10, 8, 10}, {1, 1, 9, 7}, 90, 95);
  ASSERT_EQ(mask.size(), 8U * 6U);
  for (int v = 0; v < 6; ++v)
    for (int u = 0; u < 8; ++u)
      EXPECT_EQ(mask[static_cast<std::size_t>(v * 8 + u)] != 0, u >= 1 && u < 7 && v >= 1 && v < 5) << u << " " << v;
}

TEST(OrderedWork, GivesEveryResultInOrderWhateverTheThreads) {
  for (const int threads : {1, 2, 5}) {
    OrderedWork<std::size_t> work(threads, 200, 3, [](std::size_t item, int) {
      volatile std::size_t sum = 0;
      for (std::size_t i = 0; i < (item * 7919) % 5000; ++i) sum = sum + i;
      return item * item;
    });
    for (std::size_t i = 0; i < 200; ++i) ASSERT_EQ(work.take(), i * i);
  }
  // Left half way: the threads end all the same.
  OrderedWork<int> left(4, 1000, 2, [](std::size_t item, int) { return static_cast<int>(item); });
  EXPECT_EQ(left.take(), 0);
}

}  // namespace
}  // namespace srd::host
