// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "host/simulate/command.hpp"

#include <gtest/gtest.h>

#include "drivers/camera/recording_camera.hpp"
#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/recording/truth.hpp"
#include "drivers/support/text_file.hpp"
#include "tests/fakes/command_run.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::host {
namespace {

using fakes::bytes_of;
using fakes::ScratchFolder;

using Finished = fakes::CommandRun;

Finished run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "simulate");
  return fakes::run_command(add_simulate_command, std::move(arguments));
}

const std::string kSmall =
    "name = \"small\"\nframes = 3\n[camera]\nwidth = 640\nheight = 320\nfx = 1000.0\nfy = 1000.0\ncx = "
    "320.0\n"
    "cy = 160.0\n[image]\nnoise = 2.0\n";

TEST(Simulate, WritesARecordingThatReadsBackAsTheScene) {
  const ScratchFolder folder;
  const auto scene_file = folder.write("small.toml", kSmall);
  const auto out = folder.path() / "run";
  const Finished made = run({scene_file.string(), "--out", out.string()});
  ASSERT_EQ(made.exit, 0) << made.err;
  EXPECT_EQ(made.err, "");  // no progress where nobody looks
  const Scene scene = read_scene(scene_file).value();

  const auto recording = read_recording(out);
  ASSERT_TRUE(recording) << recording.error().text();
  ASSERT_EQ(recording->frames.size(), 3U);
  const auto calibration = read_calibration(out / kCalibrationName);
  ASSERT_TRUE(calibration) << calibration.error().text();
  EXPECT_EQ(calibration->camera.fx(), 1000);
  EXPECT_EQ(calibration->image_width, 640);
  const auto pose = read_pose(out / kPoseName);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->rotation - scene.pose.rotation).norm(), 1e-12);
  EXPECT_EQ(read_points(out / kPointsName).value(), scene.points());
  EXPECT_EQ(bytes_of(out / "scene.toml"), kSmall);

  const auto truth = read_truth(out / kTruthName);
  ASSERT_TRUE(truth) << truth.error().text();
  const std::string pixel_text = bytes_of(out / "truth_pixels.csv");
  const auto pixel_lines = split_lines(pixel_text);
  ASSERT_EQ(pixel_lines.size(), 3U);
  auto renderer = Renderer::make(scene);
  ASSERT_TRUE(renderer);
  GrayImage expected{std::vector<std::uint8_t>(640 * 320), 640, 320};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(recording->frames[i].time_ns, 20'000'000LL * static_cast<int>(i));
    EXPECT_EQ(truth->rows[i].time_ns, recording->frames[i].time_ns);
    EXPECT_EQ(truth->rows[i].coefficients, scene.coefficients(i));
    const auto pixels = truth_pixels(scene, i).value();
    const auto fields = split_commas(pixel_lines[i].text);
    ASSERT_EQ(fields.size(), 2 * pixels.size());
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      EXPECT_NEAR(parse_number<double>(fields[2 * k]).value(), pixels[k].x(), 1e-6);
      EXPECT_NEAR(parse_number<double>(fields[2 * k + 1]).value(), pixels[k].y(), 1e-6);
    }
    renderer->render(i, {expected.pixels.data(), 640, 320, 640});
    EXPECT_EQ(read_gray_image(out / recording->frames[i].file)->pixels, expected.pixels);
  }
  renderer->render_reference({expected.pixels.data(), 640, 320, 640});
  EXPECT_EQ(read_gray_image(out / kReferenceName)->pixels, expected.pixels);
  RecordingCamera camera(out);
  EXPECT_TRUE(camera.start());
}

TEST(Simulate, OverwritesNothingWithoutForce) {
  const ScratchFolder folder;
  const auto scene_file = folder.write("small.toml", kSmall);
  folder.write("run/truth.csv", "mine");
  const std::string out = (folder.path() / "run").string();
  const Finished refused = run({scene_file.string(), "--out", out});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_NE(refused.err.find("truth.csv"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  EXPECT_EQ(bytes_of(folder.path() / "run/truth.csv"), "mine");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "run/frames.csv"));
  EXPECT_EQ(run({scene_file.string(), "--out", out, "--force", "--frames", "1"}).exit, 0);
  EXPECT_EQ(read_recording(out)->frames.size(), 1U);
}

TEST(Simulate, SeedChangesTheNoiseAndNothingElse) {
  const ScratchFolder folder;
  const auto scene_file = folder.write("small.toml", kSmall);
  for (const char* seed : {"5", "6"})
    ASSERT_EQ(
        run({scene_file.string(), "--out", (folder.path() / seed).string(), "--seed", seed, "--frames", "1", "--pgm"}).exit, 0);
  EXPECT_EQ(bytes_of(folder.path() / "5/truth.csv"), bytes_of(folder.path() / "6/truth.csv"));
  const auto a = read_gray_image(folder.path() / "5/frame_000000.pgm"),
             b = read_gray_image(folder.path() / "6/frame_000000.pgm");
  ASSERT_TRUE(a && b);
  int different = 0, most = 0;
  for (std::size_t i = 0; i < a->pixels.size(); ++i) {
    const int d = std::abs(a->pixels[i] - b->pixels[i]);
    different += d > 0 ? 1 : 0;
    most = std::max(most, d);
  }
  EXPECT_GT(different, 640 * 320 / 2);
  EXPECT_LE(most, 18);  // twice 4.33 sigma
}

TEST(Simulate, PrintsTheBuiltInSceneWhichIsItsOwnDefault) {
  const Finished printed = run({"--default-scene"});
  EXPECT_EQ(printed.exit, 0);
  const auto scene = parse_scene(printed.out, "printed");
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->coefficients(7), default_scene().coefficients(7));
  EXPECT_EQ(scene->pose.rotation, default_scene().pose.rotation);
}

TEST(Simulate, SaysWhatIsWrongWithItsArguments) {
  const ScratchFolder folder;
  const auto wrong = folder.write("wrong.toml", "frames = 3\n[pattern]\nrows = 1\n");
  const std::string out = (folder.path() / "run").string();
  const Finished bad = run({wrong.string(), "--out", out});
  EXPECT_EQ(bad.exit, 2);
  EXPECT_NE(bad.err.find(wrong.string() + ":3: key 'pattern.rows'"), std::string::npos) << bad.err;
  EXPECT_EQ(run({(folder.path() / "none.toml").string(), "--out", out}).exit, 2);
  EXPECT_EQ(run({wrong.string()}).exit, 2);
  EXPECT_EQ(run({"--frames", "0", "--out", out}).exit, 2);
  EXPECT_EQ(run({"--seed", "-1", "--out", out}).exit, 2);
  folder.write("file", "x");
  EXPECT_EQ(run({"--frames", "1", "--out", (folder.path() / "file").string()}).exit, 3);
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace srd::host
