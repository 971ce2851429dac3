// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/node.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "tests/fakes/live_camera.hpp"
#include "tests/fakes/notify_socket.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr const char* kSimulatedNode = "[camera]\nsource = \"simulator\"\nrate = \"max\"\n[surface]\nguess_mm = [80]\n";

Outcome<RunReport> run(const NodeConfig& config, const RunOptions& options, const std::atomic<bool>& stop) {
  auto instrument = make_instrument(config);
  EXPECT_TRUE(instrument.ok()) << instrument.error().text();
  return run_node(config, *instrument, options, stop);
}

TEST(Node, TellsTheServiceManagerItsWholeLife) {
  fakes::NotifySocket manager(60'000'000);
  const auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  RunOptions options;
  options.frames = 10;
  const std::atomic<bool> stop{false};
  const auto report = run(*config, options, stop);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_EQ(report->records, 10u);
  const auto said = manager.said();
  ASSERT_GE(said.size(), 4u);
  EXPECT_EQ(said.front(), "READY=1");
  EXPECT_EQ(said.back(), "STOPPING=1");
  EXPECT_EQ(std::count(said.begin(), said.end(), "WATCHDOG=1"), 1);  // a quarter of a minute is far
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& s) { return s.starts_with("STATUS="); }));
}

TEST(Node, RecordsWhatItMeasures) {
  const fakes::ScratchFolder scratch;
  auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  config->recording.folder = scratch.path() / "rec";
  config->recording.min_free_mib = 0;
  std::string said;
  RunOptions options;
  options.frames = 8;
  options.notify = [&](const std::string& lines) { said += lines; };
  const std::atomic<bool> stop{false};
  const auto report = run(*config, options, stop);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_EQ(report->recorded, 8u);
  EXPECT_EQ(report->record_dropped, 0u);
  EXPECT_NE(said.find("rec"), std::string::npos);
  EXPECT_NE(report->text().find("recorded  8 frames"), std::string::npos) << report->text();
  config->camera = CameraSource{"recording", (scratch.path() / "rec").string()};
  config->recording.folder.clear();
  config->lx_mm = 240;
  config->ly_mm = 440;
  const auto replay = run(*config, {}, stop);
  ASSERT_TRUE(replay.ok()) << replay.error().text();
  EXPECT_EQ(replay->surfaces, 8u);
}

TEST(Node, MeasuresOnADiskThatTakesNoRecording) {
  const fakes::ScratchFolder scratch;
  scratch.write("file", "");
  auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  const RecordingSection full{.folder = scratch.path() / "rec", .min_free_mib = std::uint64_t{1} << 40};
  const RecordingSection nowhere{.folder = scratch.path() / "file/rec", .min_free_mib = 0};
  for (const RecordingSection& section : {full, nowhere}) {
    fakes::NotifySocket manager;
    config->recording = section;
    std::string said;
    RunOptions options;
    options.frames = 3;
    options.notify = [&](const std::string& lines) { said += lines; };
    const std::atomic<bool> stop{false};
    const auto report = run(*config, options, stop);
    ASSERT_TRUE(report.ok()) << report.error().text();
    EXPECT_EQ(report->records, 3u);
    EXPECT_NE(said.find("the measurement goes on"), std::string::npos) << said;
    EXPECT_NE(report->text().find("recorded  0 frames"), std::string::npos) << report->text();
    EXPECT_FALSE(report->record_problem.empty());
    const auto statuses = manager.said();
    EXPECT_TRUE(std::any_of(statuses.begin(), statuses.end(),
                            [](const std::string& s) { return s.find("recording stopped") != std::string::npos; }));
    config->recording.numbered_folders = false;  // by hand
    const auto refused = run(*config, options, stop);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().exit, Exit::kInput);
  }
}

TEST(Node, MeasuresWhileItsHostHasNoAddress) {
  fakes::NotifySocket manager;
  auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  config->host = "flume..invalid:47810";  // two dots in a row are no name: no network is asked
  RunOptions options;
  options.frames = 5;
  const std::atomic<bool> stop{false};
  const auto report = run(*config, options, stop);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_EQ(report->records, 5u);
  EXPECT_EQ(report->transmitter.unacknowledged, 5u);
  EXPECT_NE(report->text().find("cannot resolve 'flume..invalid'"), std::string::npos) << report->text();
  const auto said = manager.said();
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& s) {
    return s.find("the host's name has no address yet") != std::string::npos;
  }));
}

// A camera whose driver's stamps cannot be true.
class BadlyStampedCamera final : public fakes::LiveCamera {
 public:
  using LiveCamera::LiveCamera;
  Capture next(CameraFrame& frame, Nanoseconds) noexcept override {
    frame = {};
    frame.image = {pixels_.data(), width(), height(), width()};
    frame.sequence = sequence_++;
    frame.time_ns = static_cast<std::int64_t>(sequence_);
    frame.clock = ClockId::kMonotonic;
    count_one(faults_.bad_stamps);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return Capture::kFrame;
  }

 private:
  std::vector<std::uint8_t> pixels_ = std::vector<std::uint8_t>(static_cast<std::size_t>(width() * height()), 90);
  std::uint64_t sequence_ = 0;
};

TEST(Node, SaysOnceThatTheDriversTimesCannotBeTrueAndCountsThem) {
  const auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok());
  instrument->camera = std::make_unique<BadlyStampedCamera>(instrument->width, instrument->height);
  std::string said;
  RunOptions options;
  options.frames = 6;
  options.notify = [&](const std::string& lines) { said += lines; };
  const std::atomic<bool> stop{false};
  const auto report = run_node(*config, *instrument, options, stop);
  ASSERT_TRUE(report.ok()) << report.error().text();
  const std::size_t at = said.find("times that cannot be true");
  ASSERT_NE(at, std::string::npos) << said;
  EXPECT_EQ(said.find("times that cannot be true", at + 1), std::string::npos) << said;
  EXPECT_NE(report->text().find("impossible time stamps"), std::string::npos) << report->text();
}

TEST(Node, ARunWithoutASurfaceSaysWhyAndWhatToLookAt) {
  const auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok());
  instrument->camera = std::make_unique<BadlyStampedCamera>(instrument->width, instrument->height);  // evenly grey
  RunOptions options;
  options.frames = 5;
  const std::atomic<bool> stop{false};
  const auto report = run_node(*config, *instrument, options, stop);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_NE(report->without_surface.find(" searching; the image has little contrast"), std::string::npos)
      << report->without_surface;
  EXPECT_NE(report->text().find("surface   none in any frame: " + report->without_surface), std::string::npos)
      << report->text();
  const auto measured = run(*config, options, stop);
  ASSERT_TRUE(measured.ok());
  EXPECT_EQ(measured->without_surface, "");
}

TEST(Node, EndsInOrderWhenStopped) {
  const auto config = NodeConfig::parse(kSimulatedNode, "node.toml");
  ASSERT_TRUE(config.ok());
  const std::atomic<bool> stop{true};
  const auto report = run(*config, {}, stop);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->captured, report->records);
}

}  // namespace
}  // namespace srd::firmware
