// SPDX-License-Identifier: Apache-2.0
// Every field of proto/srd.proto is filled by what a node runs: frame loop, status maker and sender. The datagrams are read
// with libprotobuf, whose reflection lists the fields, so a new field without anybody who fills it fails here.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <set>
#include <string>
#include <thread>
#include <vector>

#include "drivers/camera/simulator_camera.hpp"
#include "drivers/geometry/camera_errors.hpp"
#include "drivers/support/system_clock.hpp"
#include "drivers/support/unique_fd.hpp"
#include "firmware/config/instrument.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/node/status_maker.hpp"
#include "firmware/transmit/sender.hpp"
#include "proto/host_codec.hpp"
#include "srd.pb.h"
#include "tests/fakes/live_camera.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr const char* kNode =
    "[camera]\nsource = \"simulator\"\n[[water.plate]]\nthickness_mm = 5\nindex = 1.49\n"
    "[surface]\nguess_mm = [79]\nx0_mm = 1\ny0_mm = 2\n";

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

void list_fields(const Descriptor& of, std::set<std::string>& fields) {
  for (int i = 0; i < of.field_count(); ++i) {
    fields.insert(of.field(i)->full_name());
    if (const Descriptor* inner = of.field(i)->message_type()) list_fields(*inner, fields);
  }
}

// Fields that are not 0, false, empty or missing.
void list_filled(const Message& message, std::set<std::string>& fields) {
  std::vector<const FieldDescriptor*> set;
  const auto& reflection = *message.GetReflection();
  reflection.ListFields(message, &set);
  for (const FieldDescriptor* field : set) {
    fields.insert(field->full_name());
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) list_filled(reflection.GetMessage(message, field), fields);
    for (int i = 0; field->is_repeated() && i < reflection.FieldSize(message, field); ++i)
      list_filled(reflection.GetRepeatedMessage(message, field, i), fields);
  }
}

// Keeps the page faults of the capturing thread coming: a page that was never touched, and one that is on the disk only.
class Faults {
 public:
  explicit Faults(const fakes::ScratchFolder& folder)
      : file_(::open(folder.write("pages", std::string(kBytes, 'x')).c_str(), O_RDONLY | O_CLOEXEC)) {
    fresh_ = static_cast<char*>(::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    on_disk_ = static_cast<char*>(::mmap(nullptr, kBytes, PROT_READ, MAP_PRIVATE, file_.get(), 0));
    (void)::madvise(on_disk_, kBytes, MADV_RANDOM);
    // Its pages only, as fsync would wait for whatever else the disk is busy with.
    (void)::sync_file_range(file_.get(), 0, 0,
                            SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
    (void)::posix_fadvise(file_.get(), 0, kBytes, POSIX_FADV_DONTNEED);
  }
  ~Faults() {
    ::munmap(fresh_, kBytes);
    ::munmap(on_disk_, kBytes);
  }
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;
  void cause() noexcept {
    fresh_[at_] = 1;
    sum += on_disk_[at_];
    at_ += 4096;
  }
  int sum = 0;

 private:
  static constexpr std::size_t kBytes = 4096 * 64;
  UniqueFd file_;
  char* fresh_ = nullptr;
  char* on_disk_ = nullptr;
  std::size_t at_ = 0;
};

// A recording-like camera with everything that can happen to one: dark frames first, until page faults count.
class EventfulCamera final : public Camera {
 public:
  static constexpr std::uint64_t kDark = PageFaults::kWarmUp + 10, kEnd = kDark + 12;
  explicit EventfulCamera(Faults& faults) : simulator_(default_scene(), {.pace = Pace::kMax}), page_faults_(faults) {}
  Outcome<void> start() override {
    auto started = simulator_.start();
    black_.assign(static_cast<std::size_t>(width() * height()), 3);
    return started;
  }
  Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override {
    const std::uint64_t call = calls_++;
    if (call == kEnd) return Capture::kEnd;
    if (call == kDark + 2) return Capture::kDisconnected;
    const bool dark = call < kDark;
    if (call > PageFaults::kWarmUp && dark) page_faults_.cause();
    Capture got = Capture::kFrame;
    if (dark)
      frame.image = {black_.data(), width(), height(), width()};
    else
      got = simulator_.next(frame, timeout);
    frame.sequence = call + (call > kDark + 4 ? 3 : 0);
    frame.time_ns = kSecondNs + 20'000'000 * static_cast<std::int64_t>(frame.sequence);
    frame.clock = ClockId::kMonotonic;
    frame.exposure_us = 2000;
    frame.strobe = dark ? StrobePhase::kDark : StrobePhase::kLit;
    faults_.bad_stamps = 1;
    if (call != kDark + 6) return got;
    simulator_.give_back(frame);
    return Capture::kBadFrame;
  }
  void give_back(const CameraFrame& frame) noexcept override {
    if (frame.strobe == StrobePhase::kLit) simulator_.give_back(frame);
  }
  void stop() noexcept override { simulator_.stop(); }
  int width() const override { return simulator_.width(); }
  int height() const override { return simulator_.height(); }
  int buffer_count() const override { return simulator_.buffer_count(); }
  bool live() const override { return false; }

 private:
  SimulatorCamera simulator_;
  std::vector<std::uint8_t> black_;
  Faults& page_faults_;
  std::uint64_t calls_ = 0;
};

// Live, and faster than its frames are taken.
class OverrunCamera final : public fakes::LiveCamera {
 public:
  OverrunCamera() : LiveCamera(1280, 640), pixels_(static_cast<std::size_t>(1280 * 640), 90) {}
  Capture next(CameraFrame& frame, Nanoseconds) noexcept override {
    if (given_ == 4) return Capture::kEnd;
    frame = {};
    frame.image = {pixels_.data(), width(), height(), width()};
    frame.sequence = given_++;
    return Capture::kFrame;
  }

 private:
  std::vector<std::uint8_t> pixels_;
  std::uint64_t given_ = 0;
};

ClockHealth followed_clock() noexcept {
  return {.state = proto::ClockState::kSynchronised, .offset_ns = 12, .uncertainty_ns = 3000};
}

// The host has all frames below first_missing in its file, and some after.
std::vector<std::uint8_t> acknowledged_until(std::uint64_t first_missing) {
  proto::Acknowledgement acknowledgement;
  acknowledgement.of = {*proto::NodeId::make("cam-1"), 7};
  acknowledgement.session = acknowledgement.serial = 1;
  acknowledgement.first_missing = first_missing;
  acknowledgement.known_end = first_missing + 4;
  acknowledgement.missing.push({first_missing + 1, first_missing + 2});
  return proto::encode_datagram(acknowledgement);
}

class WireFields : public testing::Test {
 protected:
  void SetUp() override {
    health_.write("sys/class/thermal/thermal_zone0/type", "cpu-thermal\n");
    health_.write("sys/class/thermal/thermal_zone0/temp", "48000\n");
    health_.write("sys/devices/platform/soc/soc:firmware/get_throttled", "50005\n");
  }
  proto::NodeStatus status_of(const FrameLoop& loop, const FrameRecorder* recorder) {
    StatusMaker maker("9.9.9", {"killed by signal 9", 2}, {health_.path(), followed_clock});
    StrobeCounters strobe;
    strobe.late = 4;
    return maker.make(loop, recorder, &strobe, 1, false);
  }
  // All datagrams that are due, as the host's library reads them.
  void read_all(Sender& sender, std::int64_t now) {
    for (auto bytes = sender.next(now); !bytes.empty(); bytes = sender.next(now)) {
      wire::NodeDatagram datagram;
      ASSERT_TRUE(datagram.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
      list_filled(datagram, filled_);
    }
  }

  fakes::ScratchFolder health_, recordings_;
  std::set<std::string> filled_;
};

TEST_F(WireFields, AreAllFilledBySomethingThatANodeRuns) {
  // A metric and a bound of its own: neither is a default that would go unseen.
  auto config = NodeConfig::parse(std::string(kNode) + "upper_mm = [79.5, 500, 500, 500, 500]\n" +
                                      "[estimator]\nmetric = \"disparity\"\n[tracker]\nmax_rms_px = 100\n",
                                  "node.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  config->pace = Pace::kMax;
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();

  Faults faults(recordings_);
  EventfulCamera camera(faults);
  ASSERT_TRUE(camera.start().ok());
  RecordingSection section;
  section.folder = recordings_.path() / "rec";
  section.min_free_mib = 0;
  auto recorder = FrameRecorder::start(section, instrument->rig, camera.width(), camera.height());
  ASSERT_TRUE(recorder.ok()) << recorder.error().text();

  SenderOptions sending;
  sending.from = {*proto::NodeId::make("cam-1"), 7};
  sending.ring_frames = 60;  // fewer than there are records: the oldest are lost
  Sender sender(sending);
  KnownErrors known;
  known.errors.pose.diagonal().setConstant(1e-6);
  const auto pattern = instrument->tracker->pattern();
  CameraDoubts doubts{dsp::SystematicWatch({{instrument->rig.calibration.camera, instrument->rig.pose}, known.errors},
                                           camera.width(), camera.height(), instrument->rig.points,
                                           {*instrument->rig.optics.model, dsp::Coefficients<double>::Unit(5, 0) * 79,
                                            instrument->rig.optics.media},
                                           pattern.centre()),
                      20000, 20001};
  FrameLoopOptions options;
  options.doubts = &doubts;
  options.on_frame = [&](const CameraFrame& frame) {
    if (frame.strobe == StrobePhase::kDark) return;
    (*recorder)->take(frame, true);
    (*recorder)->take(frame, true);  // the second time it is no newer: dropped
  };
  FrameLoop loop(camera, *instrument->tracker, options, [&](const proto::CoefficientFrame& record) {
    EXPECT_TRUE(sender.push(record));
    if (sender.next_sequence() == 20) {  // the host has the first ones: what is lost does not begin at 0
      read_all(sender, kSecondNs / 2);
      sender.receive(acknowledged_until(6), kSecondNs / 2);
    }
    return true;
  });
  rusage before{}, after{};
  std::thread capture([&] {
    (void)::getrusage(RUSAGE_THREAD, &before);
    loop.capture();
    (void)::getrusage(RUSAGE_THREAD, &after);
  });
  loop.process();
  capture.join();
  (*recorder)->finish();

  OverrunCamera live;
  auto other = make_instrument(*config);
  ASSERT_TRUE(other.ok());
  FrameLoop overrun(live, *other->tracker, {}, [](const proto::CoefficientFrame&) { return false; });
  overrun.capture();  // all of them, before the first is processed
  overrun.process();

  sender.set_status(status_of(loop, recorder->get()), clock_ns(CLOCK_REALTIME) - kSecondNs);
  read_all(sender, kSecondNs);
  read_all(sender, 3 * kSecondNs);  // nobody has answered: sent again
  sender.set_status(status_of(overrun, nullptr), clock_ns(CLOCK_REALTIME) - kSecondNs);
  read_all(sender, 6 * kSecondNs);

  const auto answer = acknowledged_until(1);
  wire::HostDatagram host;
  ASSERT_TRUE(host.ParseFromArray(answer.data(), static_cast<int>(answer.size())));
  list_filled(host, filled_);

  // A keyed link's.
  const proto::Key key{std::array<std::uint8_t, proto::Key::kBytes>{1}};
  sending.key = key;
  Sender keyed(sending);
  read_all(keyed, kSecondNs);
  const auto welcome = proto::encode_datagram(
      proto::Welcome{.of = sending.from, .session = 1, .serial = 1, .from_node = {2}, .from_host = {3}}, key);
  ASSERT_TRUE(host.ParseFromArray(welcome.data(), static_cast<int>(welcome.size())));
  list_filled(host, filled_);

  std::set<std::string> all;
  list_fields(*wire::NodeDatagram::descriptor(), all);
  list_fields(*wire::HostDatagram::descriptor(), all);
  ASSERT_GT(all.size(), 80U);
  if (after.ru_majflt == before.ru_majflt) {
    RecordProperty("no_major_faults", "this system's files are all in memory");
    all.erase("srd.wire.NodeStatus.major_faults");
  }
  for (const std::string& field : all) EXPECT_TRUE(filled_.contains(field)) << field << " is never filled";
}

}  // namespace
}  // namespace srd::firmware
