// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "drivers/camera/simulator_camera.hpp"
#include "drivers/camera/v4l2/v4l2_camera.hpp"
#include "drivers/recording/image_file.hpp"
#include "firmware/stills/stills.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/scripted_v4l2_port.hpp"

namespace srd::firmware {
namespace {

// Of a quarter of the built-in flume's pixels, ten frames a second.
constexpr const char* kCamera =
    "[camera]\nwidth = 640\nheight = 320\nfx = 1075\nfy = 1075\ncx = 323.4\ncy = 157.7\nrate_hz = 10\n";
const std::string kStillWater = std::string(kCamera) + "[[surface.mode]]\nname = \"A00\"\nmean_mm = 80.0\n";
const std::string kWaves = kCamera;  // those of the built-in scene

// What a run said, and what it was asked while it ran.
struct Table {
  StillsOptions options;
  std::string said;
  int asks = 0;     // how often somebody asks, one after the other
  int answers = 0;  // stills taken or not
  std::atomic<bool> stop{false};

  explicit Table(const std::filesystem::path& folder) {
    options.folder = folder;
    options.asked = [this] {
      if (answers >= asks || asked_ > answers) return false;  // one is under way
      ++asked_;
      return true;
    };
    options.notify = [this](const std::string& lines) {
      said += lines;
      if (lines.starts_with("still ") || lines.starts_with("not taken ")) ++answers;
      if (asks > 0 && answers == asks) stop = true;
    };
  }

 private:
  int asked_ = 0;
};

StillsReport taken_of(Camera& camera, Table& table) {
  const auto started = camera.start();
  EXPECT_TRUE(started.ok()) << started.error().text();
  LitFrames frames(camera, nullptr, {});
  const auto report = take_stills(camera, frames, table.options, table.stop);
  EXPECT_TRUE(report.ok()) << report.error().text();
  return report ? *report : StillsReport{};
}

SimulatorCamera simulated(const std::string& scene, std::uint64_t frames) {
  auto parsed = parse_scene(scene, "scene.toml");
  EXPECT_TRUE(parsed.ok()) << parsed.error().text();
  return SimulatorCamera(*parsed, {Pace::kMax, frames});
}

std::vector<std::string> files_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Stills, AreTheCamerasOwnPixelsUnderNumbersThatGoOn) {
  const fakes::ScratchFolder scratch;
  scratch.write("out/still_007.png", "somebody else's");
  scratch.write("out/still_3_old.png", "no still of ours");
  Table table(scratch.path() / "out");
  table.asks = 2;
  SimulatorCamera camera = simulated(kStillWater, 20);
  EXPECT_EQ(taken_of(camera, table).taken, 2u) << table.said;
  EXPECT_EQ(files_of(table.options.folder),
            (std::vector<std::string>{"still_007.png", "still_008.png", "still_009.png", "still_3_old.png"}));
  EXPECT_EQ(fakes::bytes_of(table.options.folder / "still_007.png"), "somebody else's");
  const auto image = read_gray_image(table.options.folder / "still_008.png");
  ASSERT_TRUE(image.ok());
  // Every frame has noise of its own: one of them is this image, to the last bit.
  ASSERT_TRUE(camera.start().ok());
  CameraFrame frame;
  int same = 0;
  for (int n = 0; n < 8 && camera.next(frame, std::chrono::seconds(1)) == Capture::kFrame; ++n) {
    bool equal = true;
    for (int v = 0; v < image->height && equal; ++v)
      equal = std::equal(frame.image.row(v), frame.image.row(v) + image->width, image->view().row(v));
    same += equal ? 1 : 0;
    camera.give_back(frame);
  }
  EXPECT_EQ(same, 1);
  EXPECT_NE(table.said.find("still_008.png: 21 x 11 corners"), std::string::npos) << table.said;
  EXPECT_NE(table.said.find("where it was in still_008.png"), std::string::npos) << table.said;
}

TEST(Stills, OfABoardThatMovesAreNotTakenAndTheSpeedIsSaid) {
  const fakes::ScratchFolder scratch;
  Table table(scratch.path() / "out");
  table.asks = 1;
  SimulatorCamera camera = simulated(kWaves, 40);
  EXPECT_EQ(taken_of(camera, table).taken, 0u);
  EXPECT_NE(table.said.find("not taken the board moves: "), std::string::npos) << table.said;
  EXPECT_NE(table.said.find("allowed are 0.10 px"), std::string::npos) << table.said;
  EXPECT_TRUE(files_of(table.options.folder).empty());
}

TEST(Stills, OfABlurredBoardAreNotTakenAndTheBlurIsSaid) {
  const fakes::ScratchFolder scratch;
  Table table(scratch.path() / "out");
  table.asks = 1;
  SimulatorCamera camera = simulated(kStillWater + "[image]\nblur_px = 2.3\n", 40);
  EXPECT_EQ(taken_of(camera, table).taken, 0u);
  double blur = 0;
  ASSERT_EQ(std::sscanf(table.said.c_str(), "not taken the image is not sharp: edges of %lf px", &blur), 1) << table.said;
  EXPECT_NEAR(blur, std::hypot(2.3, std::sqrt(1.0 / 12)), 0.1);
}

TEST(Stills, WithoutABoardSayWhatIsWrongWithTheImage) {
  const fakes::ScratchFolder scratch;
  Table table(scratch.path() / "out");
  table.asks = 1;
  SimulatorCamera camera = simulated(kStillWater + "[light]\ndark = 5\nbright = 9\n", 40);
  EXPECT_EQ(taken_of(camera, table).taken, 0u);
  EXPECT_NE(table.said.find("not taken there is no board of at least 4 x 4 corners in the image: the image is nearly black"),
            std::string::npos)
      << table.said;
}

TEST(Stills, ByThemselvesAreOnlyOfABoardThatIsElsewhere) {
  const fakes::ScratchFolder scratch;
  Table table(scratch.path() / "out");
  table.options.every_s = 0.4;
  SimulatorCamera camera = simulated(kStillWater, 20);  // 2 s
  const StillsReport report = taken_of(camera, table);
  EXPECT_EQ(report.taken, 1u) << table.said;
  EXPECT_GE(report.refused, 1u);
  EXPECT_NE(table.said.find("not taken the board is where it was in still_001.png"), std::string::npos) << table.said;
}

TEST(Stills, AFolderThatTakesNoneIsSaidAndLeavesNothing) {
  const fakes::ScratchFolder scratch;
  scratch.write("file", "no folder");
  Table table(scratch.path() / "file" / "out");
  SimulatorCamera camera = simulated(kStillWater, 10);
  ASSERT_TRUE(camera.start().ok());
  LitFrames frames(camera, nullptr, {});
  const auto report = take_stills(camera, frames, table.options, table.stop);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().exit, Exit::kInput);
}

// A board of 9 x 7 corners, 40 px apart, edges of 0.9 px, at a place.
std::uint8_t board_at(double u0, double v0, int u, int v) {
  const auto edge = [](double x, double first, int lines) {
    double sign = 1, value = -1;
    for (int i = 0; i < lines; ++i, sign = -sign) value += sign * (1 + std::erf((x - first - 40 * i) / (0.9 * M_SQRT2)));
    return value;
  };
  const bool inside = u > u0 - 40 && u < u0 + 9 * 40 && v > v0 - 40 && v < v0 + 7 * 40;
  return static_cast<std::uint8_t>(inside ? std::lround(120 + 90 * edge(u, u0, 9) * edge(v, v0, 7)) : 120);
}

constexpr std::uint64_t kMoving = 20;  // frames

TEST(Stills, OfAV4l2CameraAreTakenOnceTheBoardStandsStill) {
  const fakes::ScratchFolder scratch;
  Table table(scratch.path() / "out");
  table.asks = 1;
  fakes::ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_Y10, 480, 360, {30}}};
  // 0.3 px a frame, then none.
  device.scene = [](std::uint64_t frame, int u, int v) {
    return board_at(70.3 + 0.3 * static_cast<double>(std::min(frame, kMoving)), 60.7, u, v);
  };
  V4l2CameraOptions options;
  options.ask.path = device.path;
  options.ask.width = 480;
  options.ask.height = 360;
  V4l2Camera camera(options, std::make_unique<fakes::ScriptedV4l2Port>(device));
  EXPECT_EQ(taken_of(camera, table).taken, 1u) << table.said;
  EXPECT_GT(device.frames, kMoving);
  EXPECT_LT(device.frames, kMoving + 10);
  const auto image = read_gray_image(table.options.folder / "still_001.png");
  ASSERT_TRUE(image.ok());
  for (int v = 0; v < 360; ++v)
    for (int u = 0; u < 480; ++u)
      ASSERT_EQ(image->view().row(v)[u], board_at(70.3 + 0.3 * kMoving, 60.7, u, v)) << u << ", " << v;
}

TEST(Stills, ASpeedBelowTheLimitIsNoMotionAndOneAboveItIsMeasured) {
  for (const double step : {0.01, 0.04, 0.2}) {
    const fakes::ScratchFolder scratch;
    Table table(scratch.path() / "out");
    table.asks = 1;
    fakes::ScriptedV4l2Device device;
    device.formats = {{V4L2_PIX_FMT_GREY, 480, 360, {30}}};
    device.scene = [step](std::uint64_t frame, int u, int v) {
      return board_at(70.3 + step * static_cast<double>(frame), 60.7, u, v);
    };
    V4l2CameraOptions options;
    options.ask.path = device.path;
    options.ask.width = 480;
    options.ask.height = 360;
    V4l2Camera camera(options, std::make_unique<fakes::ScriptedV4l2Port>(device));
    const StillsReport report = taken_of(camera, table);
    // Two frames of 33 ms lie between those that are compared.
    EXPECT_EQ(report.taken, 2 * step < 0.1 ? 1u : 0u) << table.said;
    double moved = 0;
    const std::string::size_type at = table.said.find(report.taken > 0 ? "moved " : "moves: ");
    ASSERT_NE(at, std::string::npos) << table.said;
    ASSERT_EQ(std::sscanf(table.said.c_str() + at, report.taken > 0 ? "moved %lf px" : "moves: %lf px", &moved), 1);
    EXPECT_NEAR(moved, 2 * step, 0.015) << table.said;
  }
}

}  // namespace
}  // namespace srd::firmware
