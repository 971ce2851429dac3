// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/doctor.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "firmware/config/strobe_factory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/net/udp_socket.hpp"
#include "drivers/support/key_file.hpp"
#include "proto/host_codec.hpp"
#include "tests/fakes/live_camera.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

NodeConfig simulated(const std::string& more = {}) {
  auto config = NodeConfig::parse(
      "[camera]\nsource = \"simulator\"\nrate = \"max\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n" + more,
      "node.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  return *config;
}

DoctorOptions quick(const std::filesystem::path& root = "/nowhere") {
  DoctorOptions options;
  options.root = root;
  options.wake_ups = std::chrono::milliseconds(20);
  options.camera_time = std::chrono::milliseconds(1000);
  options.answer_time = std::chrono::milliseconds(300);
  options.write_bytes = 1 << 20;
  return options;
}

const Finding& about(const Diagnosis& diagnosis, const std::string& subject) {
  static const Finding kNone{Verdict::kFail, "", "no finding"};
  for (const Finding& finding : diagnosis.findings())
    if (finding.subject == subject) return finding;
  ADD_FAILURE() << "nothing was found about " << subject;
  return kNone;
}

void expect(const Diagnosis& diagnosis, const std::string& subject, Verdict verdict, const char* part) {
  const Finding& finding = about(diagnosis, subject);
  EXPECT_EQ(finding.verdict, verdict) << finding.text();
  EXPECT_NE(finding.text().find(part), std::string::npos) << finding.text();
  EXPECT_EQ(finding.advice.empty(), verdict == Verdict::kOk) << finding.text();
}

TEST(Doctor, FindsNothingWrongWithASimulatedNode) {
  const fakes::ScratchFolder scratch;
  NodeConfig config = simulated();
  config.recording.folder = scratch.path() / "new/rec";
  config.recording.min_free_mib = 0;
  const Outcome<NodeConfig> loaded = config;
  Diagnosis diagnosis;
  DoctorOptions options = quick();
  options.camera_time = std::chrono::milliseconds(4000);  // an emulated board renders a frame a second
  examine(&loaded, options, diagnosis);
  EXPECT_EQ(diagnosis.exit(), Exit::kDone);
  expect(diagnosis, "camera", Verdict::kOk, "simulator");
  expect(diagnosis, "frames", Verdict::kOk, "50.00 frames/s, 0 missing");
  expect(diagnosis, "light", Verdict::kOk, "grey");
  expect(diagnosis, "pattern", Verdict::kOk, "231 of 231 corners");
  EXPECT_NE(about(diagnosis, "disk").found.find("MiB free, writes"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "new")) << "a look leaves nothing behind";
  for (const char* subject :
       {"configuration", "GPIO", "clock", "wake-ups", "priority", "memory", "groups", "network", "temperature", "throttling"})
    (void)about(diagnosis, subject);
}

TEST(Doctor, GoesOnAfterEveryFailure) {
  const Outcome<NodeConfig> broken = Problem{Exit::kUsage, "2 problems in the file", "node.toml"};
  Diagnosis diagnosis;
  examine(&broken, quick(), diagnosis);
  EXPECT_EQ(diagnosis.exit(), Exit::kUsage);
  EXPECT_GE(diagnosis.findings().size(), 8u);
  NodeConfig config = simulated();
  config.camera = CameraSource{"recording", "/nowhere"};
  config.host = "flume..invalid:47810";
  config.recording.folder = "/proc/rec";
  config.recording.min_free_mib = 0;
  const Outcome<NodeConfig> loaded = config;
  Diagnosis second;
  examine(&loaded, quick(), second);
  EXPECT_EQ(second.exit(), Exit::kInput) << "of the first that failed";
  expect(second, "camera", Verdict::kFail, "no such folder");
  expect(second, "network", Verdict::kFail, "cannot resolve");
  EXPECT_EQ(about(second, "disk").verdict, Verdict::kFail);
  (void)about(second, "throttling");
}

TEST(Doctor, TellsTheTechnicianWhatIsWrongWithTheImage) {
  const fakes::ScratchFolder scratch;
  Scene scene = default_scene();
  for (const auto& [grey, word] : {std::pair{3, "too dark"}, {255, "too bright"}}) {
    const std::string folder = "rec" + std::to_string(grey);
    const std::string image = "P5\n" + std::to_string(scene.width()) + " " + std::to_string(scene.height()) + "\n255\n" +
                              std::string(static_cast<std::size_t>(scene.width() * scene.height()), static_cast<char>(grey));
    std::string listing = "file,sequence,time_ns,exposure_us,strobe\n";
    for (const int n : {0, 1, 2, 5}) {
      listing += "f" + std::to_string(n) + ".pgm," + std::to_string(n) + "," + std::to_string(20'000'000 * n) + ",0,0\n";
      scratch.write(folder + "/f" + std::to_string(n) + ".pgm", image);
    }
    scratch.write(folder + "/frames.csv", listing);
    ASSERT_TRUE(write_calibration(scratch.path() / folder / "calibration.yml", scene.calibration).ok());
    ASSERT_TRUE(write_pose(scratch.path() / folder / "pose.yml", scene.pose).ok());
    ASSERT_TRUE(write_points(scratch.path() / folder / "points.txt", scene.points()).ok());
    NodeConfig config = simulated();
    config.camera = CameraSource{"recording", (scratch.path() / folder).string()};
    Diagnosis diagnosis;
    check_camera(config, quick(), diagnosis);
    expect(diagnosis, "light", Verdict::kWarn, word);
    expect(diagnosis, "frames", Verdict::kWarn, "4 frames, 50.00 frames/s, 2 missing");
    expect(diagnosis, "pattern", Verdict::kWarn, "focus");
    expect(diagnosis, "pattern", Verdict::kWarn, "no surface in 4 frames");
    EXPECT_EQ(diagnosis.exit(), Exit::kDone) << "a camera that is not aimed yet is no broken one";
  }
}

// A camera that goes on changing its images, and whose times cannot be true.
class SharpeningCamera final : public fakes::LiveCamera {
 public:
  SharpeningCamera(int width, int height) : LiveCamera(width, height), pixels_(static_cast<std::size_t>(width * height), 90) {}
  std::vector<std::string> image_concerns() const override {
    return {"sharpness is 3, its least is 0: the camera sharpens edges"};
  }
  Nanoseconds conversion_time() const override { return took; }
  Nanoseconds took{0};
  Capture next(CameraFrame& frame, Nanoseconds) noexcept override {
    count_one(faults_.bad_stamps);
    frame = {};
    frame.image = {pixels_.data(), width(), height(), width()};
    frame.sequence = sequence_++;
    frame.time_ns = 20'000'000 * static_cast<std::int64_t>(sequence_);
    return Capture::kFrame;
  }

 private:
  std::vector<std::uint8_t> pixels_;
  std::uint64_t sequence_ = 0;
};

TEST(Doctor, NamesTheControlThatChangesTheImageAndTimesThatCannotBeTrue) {
  const NodeConfig config = simulated();
  auto instrument = make_instrument(config);
  ASSERT_TRUE(instrument.ok());
  instrument->camera = std::make_unique<SharpeningCamera>(instrument->width, instrument->height);
  Diagnosis diagnosis;
  check_camera(
      config, *instrument, [&](const Camera& camera) { return open_strobe(config, camera); }, quick(), diagnosis);
  expect(diagnosis, "image", Verdict::kWarn, "sharpness is 3, its least is 0");
  expect(diagnosis, "image", Verdict::kWarn, "turn that control");
  expect(diagnosis, "stamps", Verdict::kWarn, "frames with a time that cannot be true");
  EXPECT_EQ(diagnosis.exit(), Exit::kDone);
}

TEST(Doctor, TellsWhichPartOfAFramesTimeGoesIntoMakingItGrey) {
  const NodeConfig config = simulated();  // 50 Hz
  for (const auto& [ms, verdict, words] : {std::tuple{3, Verdict::kOk, "3.00 ms of the 20.00 ms between two frames (15 %)"},
                                           std::tuple{12, Verdict::kWarn, "(60 %)"}}) {
    auto instrument = make_instrument(config);
    ASSERT_TRUE(instrument.ok());
    auto camera = std::make_unique<SharpeningCamera>(instrument->width, instrument->height);
    camera->took = std::chrono::milliseconds(ms);
    instrument->camera = std::move(camera);
    Diagnosis diagnosis;
    check_camera(
        config, *instrument, [&](const Camera& lit) { return open_strobe(config, lit); }, quick(), diagnosis);
    expect(diagnosis, "conversion to grey", verdict, words);
  }
}

TEST(Doctor, ACameraWithoutFramesFails) {
  const fakes::ScratchFolder scratch;
  NodeConfig config = simulated();
  DoctorOptions options = quick();
  options.camera_time = std::chrono::milliseconds(0);
  Diagnosis diagnosis;
  check_camera(config, options, diagnosis);
  expect(diagnosis, "frames", Verdict::kFail, "0 frames");
  EXPECT_EQ(diagnosis.exit(), Exit::kDevice);
}

TEST(Doctor, AsksTheHostForAnAnswer) {
  auto local = UdpSocket::bind(*Address::parse("127.0.0.1:0", ""));
  ASSERT_TRUE(local.ok());
  NodeConfig config = simulated();
  config.host = local->local().text();
  Diagnosis silent;
  check_network(config, quick(), silent);
  expect(silent, "network", Verdict::kOk, "127.0.0.1");
  expect(silent, "host", Verdict::kFail, "srd listen");
  EXPECT_EQ(silent.exit(), Exit::kNetwork);

  std::atomic<bool> over{false};
  std::thread host([&] {
    std::array<std::uint8_t, proto::kMaxDatagram> buffer{};
    Address from;
    while (!over) {
      const std::ptrdiff_t size = local->receive(buffer, std::chrono::milliseconds(20), &from);
      if (size <= 0) continue;
      const auto heard = proto::decode_node_datagram(std::span(buffer).first(static_cast<std::size_t>(size)));
      if (!heard || !std::holds_alternative<proto::NodeStatus>(heard->content)) continue;
      proto::Acknowledgement answer;
      answer.of = heard->header.from;
      answer.session = answer.serial = 1;
      (void)local->send_to(from, proto::encode_datagram(answer));
    }
  });
  Diagnosis answered;
  check_network(config, quick(), answered);
  over = true;
  host.join();
  expect(answered, "host", Verdict::kOk, "answers within");
}

TEST(Doctor, LooksAtTheKeyOfTheLink) {
  const fakes::ScratchFolder folder;
  NodeConfig config = simulated();
  config.host = "127.0.0.1:9";
  Diagnosis none;
  check_network(config, quick(), none);
  expect(none, "key", Verdict::kWarn, "none: anyone");
  const KeyFile key{config.node_id, {SecretBytes::random()}};
  config.key = folder.path() / "node.key";
  ASSERT_TRUE(key.write(config.key).ok());
  Diagnosis good;
  check_network(config, quick(), good);
  expect(good, "key", Verdict::kOk, "node.key");
  expect(good, "host", Verdict::kFail, "nobody answers");
  EXPECT_NE(about(good, "host").advice.find("--keys"), std::string::npos);
  std::filesystem::permissions(config.key, std::filesystem::perms::group_read, std::filesystem::perm_options::add);
  Diagnosis exposed;
  check_network(config, quick(), exposed);
  expect(exposed, "key", Verdict::kFail, "others than its owner");
  EXPECT_NE(about(exposed, "key").advice.find("chmod 600"), std::string::npos);
}

TEST(Doctor, SaysWhatToSetWhereSomethingIsNotPermitted) {
  constexpr RealtimeCalls kForbidden{[](bool) { return ENOMEM; }, [] { return false; }, [](int) { return EPERM; },
                                     [](std::span<const int>) { return EPERM; }};
  constexpr RealtimeCalls kPermitted{[](bool) { return 0; }, [] { return true; }, [](int) { return 0; },
                                     [](std::span<const int>) { return 0; }};
  Diagnosis forbidden, permitted;
  check_permissions(simulated(), forbidden, kForbidden);
  expect(forbidden, "priority", Verdict::kWarn, "LimitRTPRIO");
  check_permissions(simulated(), permitted, kPermitted);
  expect(permitted, "priority", Verdict::kOk, "80");
  expect(permitted, "memory", Verdict::kOk, "without a limit");
}

TEST(Doctor, SeesAHotBoardWithAWeakSupplyAndItsGpio) {
  const fakes::ScratchFolder root;
  root.write("sys/class/thermal/thermal_zone0/type", "cpu-thermal\n");
  root.write("sys/class/thermal/thermal_zone0/temp", "86000\n");
  root.write("sys/devices/platform/soc/soc:firmware/get_throttled", "50000\n");
  root.write("dev/gpiochip0", "");
  root.write("dev/other", "");
  Diagnosis diagnosis;
  check_board(quick(root.path()), diagnosis);
  check_gpio({}, quick(root.path()), diagnosis);
  expect(diagnosis, "temperature", Verdict::kWarn, "86 C (cpu-thermal)");
  expect(diagnosis, "throttling", Verdict::kWarn, "since the start: under-voltage");
  EXPECT_NE(about(diagnosis, "throttling").advice.find("power supply"), std::string::npos);
  expect(diagnosis, "GPIO", Verdict::kOk, "can be opened: gpiochip0");
}

TEST(Doctor, ALineThatIsNotThereFails) {
  const LineAddress line{"/nowhere/gpiochip7", "17", false};
  Diagnosis diagnosis;
  check_gpio(std::span(&line, 1), quick(), diagnosis);
  expect(diagnosis, "GPIO", Verdict::kFail, gpiod_version().empty() ? "libgpiod" : "/nowhere/gpiochip7");
  EXPECT_NE(diagnosis.exit(), Exit::kDone);
}

TEST(Doctor, LooksAtTheLinesOfTheConfiguration) {
  NodeConfig config = simulated();
  config.camera = CameraSource{"v4l2", "/nowhere/video0"};
  config.strobe.mode = StrobeMode::kTrigger;
  config.strobe.chip = "/nowhere/gpiochip7";
  config.strobe.line = "17";
  config.strobe.trigger_line = "27";
  const Outcome<NodeConfig> loaded = config;
  Diagnosis diagnosis;
  examine(&loaded, quick(), diagnosis);
  EXPECT_EQ(std::count_if(diagnosis.findings().begin(), diagnosis.findings().end(),
                          [](const Finding& f) { return f.subject == "GPIO" && f.verdict == Verdict::kFail; }),
            2);
}

TEST(Doctor, LooksAtTheSpill) {
  const fakes::ScratchFolder folder;
  NodeConfig config = simulated("[transmit]\nspill = \"" + (folder.path() / "spill").string() + "\"\n");
  Diagnosis good;
  check_disk(config, quick(), good);
  expect(good, "spill", Verdict::kOk, "10000 frames");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "nothing is made";
  config.ring_frames = std::size_t{1} << 40;
  Diagnosis small;
  check_disk(config, quick(), small);
  expect(small, "spill", Verdict::kFail, "MiB free");
}

TEST(Doctor, ADiskWithoutRoomFails) {
  const fakes::ScratchFolder scratch;
  NodeConfig config = simulated();
  config.recording.folder = scratch.path() / "rec";
  config.recording.min_free_mib = std::uint64_t{1} << 40;
  Diagnosis diagnosis;
  check_disk(config, quick(), diagnosis);
  expect(diagnosis, "disk", Verdict::kFail, "MiB free");
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

}  // namespace
}  // namespace srd::firmware
