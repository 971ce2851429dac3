// SPDX-License-Identifier: Apache-2.0
#include "firmware/loop/frame_loop.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "drivers/camera/simulator_camera.hpp"
#include "firmware/config/instrument.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/live_camera.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/test_data.hpp"

namespace srd::firmware {
namespace {

Instrument instrument_of(const std::string& text, const std::string& recording = {}) {
  auto config = NodeConfig::parse(text, "node.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  config->pace = Pace::kMax;
  if (!recording.empty()) config->camera = CameraSource{"recording", recording};
  auto instrument = make_instrument(*config);
  EXPECT_TRUE(instrument.ok()) << instrument.error().text();
  return std::move(instrument).value();
}

constexpr const char* kSimulated = "[camera]\nsource = \"simulator\"\n[surface]\nguess_mm = [80]\n";
constexpr const char* kRecorded = "[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n";

// Runs capture beside and process on this thread.
std::vector<proto::CoefficientFrame> run(Camera& camera, FrameLoop& loop, std::vector<proto::CoefficientFrame>& records) {
  std::thread capture([&] { loop.capture(); });
  loop.process();
  capture.join();
  camera.stop();
  return records;
}

std::vector<proto::CoefficientFrame> run(Instrument& instrument, std::uint64_t frames) {
  const auto started = instrument.camera->start();
  EXPECT_TRUE(started.ok()) << started.error().text();
  std::vector<proto::CoefficientFrame> records;
  FrameLoop loop(*instrument.camera, *instrument.tracker, {.frames = frames}, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    return true;
  });
  return run(*instrument.camera, loop, records);
}

// A clock that moves on by a step whenever it is read.
struct SteppingClock {
  std::int64_t now_ns = 0, step_ns = 0;
  int readings = 0;
  std::int64_t read() {
    ++readings;
    return now_ns += step_ns;
  }
};

TEST(FrameLoop, TheDeadlineEndsAFitWithTheBestSurfaceSoFarAndSaysSo) {
  const auto config = [](const std::string& deadline) {
    auto made = NodeConfig::parse(std::string(kSimulated) + "[estimator]\nepsf = 0\nepsx = 0\n" + deadline, "node.toml");
    EXPECT_TRUE(made.ok()) << made.error().text();
    made->pace = Pace::kMax;
    return *made;
  };
  constexpr int kFrames = 6;
  auto free = make_instrument(config(""));
  ASSERT_TRUE(free.ok()) << free.error().text();
  const auto unhurried = run(*free, kFrames);
  for (const int readings : {1, 2}) {
    SteppingClock clock;
    clock.step_ns = 1'000'000;
    // Passed at the reading with that number, the frame's start not counted: after one step fewer.
    auto made =
        make_instrument(config("deadline_us = " + std::to_string(1000 * readings) + "\n"), [&] { return clock.read(); });
    ASSERT_TRUE(made.ok()) << made.error().text();
    const auto started = made->camera->start();
    ASSERT_TRUE(started.ok());
    std::vector<proto::CoefficientFrame> records;
    FrameLoop loop(*made->camera, *made->tracker, {.frames = kFrames, .deadline = made->deadline.get()},
                   [&](const proto::CoefficientFrame& record) {
                     records.push_back(record);
                     return true;
                   });
    run(*made->camera, loop, records);
    ASSERT_EQ(records.size(), static_cast<std::size_t>(kFrames));
    // The first frame searches the whole image: no deadline.
    EXPECT_EQ(records[0].status, proto::FrameStatus::kOk);
    for (std::size_t i = 1; i < records.size(); ++i) {
      EXPECT_EQ(records[i].status, proto::FrameStatus::kNotConverged) << i;
      EXPECT_EQ(records[i].stop, dsp::Stop::kDeadline) << i;
      EXPECT_LE(records[i].iterations, static_cast<std::uint32_t>(readings - 1)) << i;
      ASSERT_EQ(records[i].coefficients.size(), 5) << i;
      EXPECT_GT(records[i].information.size, 0) << i;
      if (readings > 1) {  // one step from the trend is all but there
        EXPECT_NEAR(records[i].coefficients[0], unhurried[i].coefficients[0], 0.1) << i;
      }
    }
    EXPECT_EQ(loop.counters().hurried, static_cast<std::uint64_t>(kFrames - 1));
    EXPECT_GT(clock.readings, kFrames);
  }
}

TEST(FrameLoop, ADeadlineFarAwayChangesNothing) {
  SteppingClock clock;
  auto config = NodeConfig::parse(std::string(kSimulated) + "[estimator]\ndeadline_us = 1000000\n", "node.toml");
  ASSERT_TRUE(config.ok());
  config->pace = Pace::kMax;
  auto instrument = make_instrument(*config, [&] { return clock.read(); });
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  for (const auto& record : run(*instrument, 3)) EXPECT_EQ(record.status, proto::FrameStatus::kOk);
}

TEST(FrameLoop, EveryFrameYieldsARecordInOrder) {
  Instrument instrument = instrument_of(kRecorded, fakes::test_data().string() + "/flume-small");
  const auto records = run(instrument, 0);
  ASSERT_EQ(records.size(), 12u);
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_EQ(records[i].source_sequence, i);
    EXPECT_EQ(records[i].status, proto::FrameStatus::kOk);
    EXPECT_EQ(records[i].stamp.clock, ClockId::kRecording);
    EXPECT_GT(records[i].corners_used, 200u);
    EXPECT_GT(records[i].information.size, 0);
  }
}

TEST(FrameLoop, RecordsSayInWhichMetricTheirErrorsAre) {
  for (const auto& [name, metric] : {std::pair{"reprojection", dsp::Metric::kReprojection},
                                     {"disparity", dsp::Metric::kDisparity},
                                     {"collinearity", dsp::Metric::kCollinearity}}) {
    auto config = NodeConfig::parse(std::string(kSimulated) + "[estimator]\nmetric = \"" + name + "\"\n", "node.toml");
    ASSERT_TRUE(config.ok()) << config.error().text();
    config->pace = Pace::kMax;
    auto instrument = make_instrument(*config);
    ASSERT_TRUE(instrument.ok()) << instrument.error().text();
    for (const auto& record : run(*instrument, 3)) {
      EXPECT_EQ(record.metric, metric);
      EXPECT_GT(record.mean_error, 0) << name;
      // The mean distance is 1.25 times the rms of one axis; half a millimetre on the bottom is a pixel, two
      // milliradians between normals are.
      if (metric == dsp::Metric::kReprojection) {
        EXPECT_GT(record.mean_error, record.reprojection_rms_px);
      } else {
        EXPECT_LT(record.mean_error, record.reprojection_rms_px) << name;
      }
    }
  }
}

TEST(FrameLoop, RecordsSayWhatTheirTimeWentInto) {
  Instrument instrument = instrument_of(kRecorded, fakes::test_data().string() + "/flume-small");
  for (const auto& record : run(instrument, 0)) {
    EXPECT_GT(record.detection_us, 0u);
    EXPECT_GT(record.estimation_us, 0u);
    EXPECT_LE(record.detection_us + record.estimation_us, record.total_us);
  }
}

// A camera whose frames are good, bad, missing and away, in a fixed order.
class FaultyCamera final : public Camera {
 public:
  FaultyCamera() : simulator_(default_scene()) {}
  Outcome<void> start() override { return simulator_.start(); }
  Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override {
    switch (calls_++) {
      case 2: return Capture::kTimeout;
      case 4:
      case 5: return Capture::kDisconnected;
      case 12: return Capture::kEnd;
      default: break;
    }
    const Capture got = simulator_.next(frame, timeout);
    frame.sequence += calls_ > 8 ? 3 : 0;  // three frames lost by the source
    if (calls_ == 8) {
      simulator_.give_back(frame);
      frame.image = {};
      return Capture::kBadFrame;
    }
    return got;
  }
  void give_back(const CameraFrame& frame) noexcept override { simulator_.give_back(frame); }
  void stop() noexcept override { simulator_.stop(); }
  int width() const override { return simulator_.width(); }
  int height() const override { return simulator_.height(); }
  int buffer_count() const override { return simulator_.buffer_count(); }
  bool live() const override { return false; }

 private:
  SimulatorCamera simulator_;
  int calls_ = 0;
};

TEST(FrameLoop, FaultsAreCountedAndSurvived) {
  Instrument instrument = instrument_of(kSimulated);
  FaultyCamera camera;
  ASSERT_TRUE(camera.start().ok());
  std::vector<proto::CoefficientFrame> records;
  FrameLoop loop(camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    return true;
  });
  run(camera, loop, records);
  ASSERT_EQ(records.size(), 9u);  // 12 calls less a time-out and two while away
  int bad = 0;
  for (const auto& record : records) bad += record.status == proto::FrameStatus::kBadFrame ? 1 : 0;
  EXPECT_EQ(bad, 1);
  EXPECT_EQ(loop.counters().bad.load(), 1u);
  EXPECT_EQ(loop.counters().disconnects.load(), 1u);
  EXPECT_EQ(loop.counters().dropped_by_source.load(), 3u);
  EXPECT_EQ(loop.counters().surfaces.load(), 8u);
  std::uint32_t dropped = 0;
  for (const auto& record : records) dropped += record.dropped_before;
  EXPECT_EQ(dropped, 3u);
}

// Live frames without anything to see, faster than anybody processes them; two are missing after the third.
class HastyCamera final : public fakes::LiveCamera {
 public:
  HastyCamera() : LiveCamera(1280, 640), pixels_(static_cast<std::size_t>(width() * height()), 100) {}
  Capture next(CameraFrame& frame, Nanoseconds) noexcept override {
    if (given_ == kFrames) return Capture::kEnd;
    frame = {};
    frame.image = {pixels_.data(), width(), height(), width()};
    frame.sequence = 100 + static_cast<std::uint64_t>(given_) + (given_ >= 3 ? 2 : 0);
    frame.time_ns = 20'000'000 * static_cast<std::int64_t>(frame.sequence);
    ++given_;
    return Capture::kFrame;
  }
  void give_back(const CameraFrame&) noexcept override { ++returned; }
  int buffer_count() const override { return kFrames; }

  static constexpr int kFrames = 8;
  int returned = 0;

 private:
  std::vector<std::uint8_t> pixels_;
  int given_ = 0;
};

TEST(FrameLoop, ALateFrameIsNoGapOfTheSource) {
  Instrument instrument = instrument_of(kSimulated);
  HastyCamera camera;
  std::vector<proto::CoefficientFrame> records;
  FrameLoop loop(camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    return true;
  });
  loop.capture();  // all of them, before the first is processed
  loop.process();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].source_sequence, 109u);
  EXPECT_EQ(records[0].dropped_before, 9u);
  EXPECT_EQ(loop.counters().dropped_late.load(), 7u);
  EXPECT_EQ(loop.counters().dropped_by_source.load(), 2u);
  EXPECT_EQ(camera.returned, HastyCamera::kFrames);
}

TEST(FrameLoop, RecordsSayWhatTheLightGoesThrough) {
  Instrument instrument = instrument_of(std::string(kSimulated) +
                                        "[water]\nrefractive_index = 1.34\n[[water.plate]]\nthickness_mm = 12\nindex = 1.49\n"
                                        "[[water.plate]]\nthickness_mm = 0.5\nindex = 1\n");
  const auto records = run(instrument, 1);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].refractive_index, 1.34f);
  ASSERT_EQ(records[0].plates.size(), 2u);
  EXPECT_EQ(records[0].plates[0].thickness, 12);
  EXPECT_EQ(records[0].plates[0].index, 1.49f);
  EXPECT_EQ(records[0].plates[1].thickness, 0.5f);
}

TEST(FrameLoop, ARecordThatFindsNoRoomIsOfferedAgain) {
  Instrument instrument = instrument_of(kRecorded, fakes::test_data().string() + "/flume-small");
  ASSERT_TRUE(instrument.camera->start().ok());
  std::vector<proto::CoefficientFrame> records;
  int refused = 0;
  FrameLoop loop(*instrument.camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame& record) {
    if (++refused % 3 != 0) return false;
    records.push_back(record);
    return true;
  });
  run(*instrument.camera, loop, records);
  EXPECT_EQ(records.size(), 12u);
}

TEST(FrameLoop, ARecordingWhoseHostIsGoneEndsAfterStopAndCountsWhatItGaveUp) {
  Instrument instrument = instrument_of(kRecorded, fakes::test_data().string() + "/flume-small");
  ASSERT_TRUE(instrument.camera->start().ok());
  FrameLoop* running = nullptr;
  int offers = 0;
  FrameLoop loop(*instrument.camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame&) {
    if (++offers == 3) running->stop();
    return false;
  });
  running = &loop;
  std::vector<proto::CoefficientFrame> records;
  run(*instrument.camera, loop, records);
  EXPECT_GT(offers, 3);
  EXPECT_GT(loop.counters().records.load(), 0u);
  EXPECT_EQ(loop.counters().dropped_transmit.load(), loop.counters().records.load());
}

TEST(FrameLoop, ALiveCameraDoesNotWaitForRoom) {
  Instrument instrument = instrument_of(kSimulated);
  HastyCamera camera;
  int offers = 0;
  FrameLoop loop(camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame&) { return ++offers == 0; });
  loop.capture();
  loop.process();
  EXPECT_EQ(offers, 1);
  EXPECT_EQ(loop.counters().dropped_transmit.load(), 1u);
}

TEST(FrameLoop, EndsSoonAfterStop) {
  Instrument instrument = instrument_of(kSimulated);
  ASSERT_TRUE(instrument.camera->start().ok());
  std::vector<proto::CoefficientFrame> records;
  FrameLoop* running = nullptr;
  FrameLoop loop(*instrument.camera, *instrument.tracker, {}, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    if (records.size() == 5) running->stop();
    return true;
  });
  running = &loop;
  run(*instrument.camera, loop, records);
  EXPECT_GE(records.size(), 5u);
  EXPECT_LE(records.size(), 5u + static_cast<std::size_t>(instrument.camera->buffer_count()));
}

// Rendering, tracking, fitting, quantising: 1,000 frames on one thread, so that the gauge sees all of it.
TEST(SlowFrameLoop, TakesNothingFromTheHeapInAThousandFrames) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  Instrument instrument = instrument_of(kSimulated);
  ASSERT_TRUE(instrument.camera->start().ok());
  std::uint64_t taken = 0;
  FrameLoop loop(*instrument.camera, *instrument.tracker, {.frames = 1000}, [&](const proto::CoefficientFrame&) {
    ++taken;
    return true;
  });
  std::int64_t captured = -1;
  std::thread capture([&] {
    const fakes::AllocationGauge gauge;
    loop.capture();
    captured = gauge.count();
  });
  {
    const fakes::AllocationGauge gauge;
    loop.process();
    EXPECT_EQ(gauge.count(), 0);
  }
  capture.join();
  EXPECT_EQ(captured, 0);
  EXPECT_EQ(taken, 1000u);
  const fakes::AllocationGauge gauge;
  const std::vector<std::uint64_t> proof(3, taken);
  EXPECT_GT(gauge.count(), 0) << "the gauge does not count";
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / n, mb += b[i] / n;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
    ab += (a[i] - ma) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

// The shipped configuration on the published recording: the plane at the ray of pixel (1429, 180) follows the published
// first coefficient. Published row k is image k.
TEST(FrameLoop, FollowsThePublishedSeriesOf2017) {
  const std::filesystem::path data = fakes::lab_data() / "opensrd-2017";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no recordings at " << data << ": set SRD_DATA";
  auto config = NodeConfig::load(fakes::test_data().string() + "/../../board/replay/opensrd-2017.toml");
  ASSERT_TRUE(config.ok()) << config.error().text();
  config->camera = CameraSource{"recording", (data / "DATA/ProcessedPaper_CAM1").string()};
  config->pace = Pace::kMax;
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  const auto records = run(*instrument, 0);
  ASSERT_EQ(records.size(), 500u);

  const auto calibration = read_calibration(data / "INPUT/Calib_CAM1.yml");
  const auto pose = read_pose(data / "INPUT/Camera_Pose_1.txt");
  ASSERT_TRUE(calibration.ok() && pose.ok());
  const dsp::View<double> view{calibration->camera, *pose};
  const auto ray = view.ray(view.camera.undistort({1429, 180}).value());
  std::ifstream published(data / "published/TimeSeries_CAM1_first500.txt");
  std::vector<double> ours, theirs;
  std::string line;
  for (const auto& record : records) {
    ASSERT_TRUE(std::getline(published, line));
    if (!record.has_surface() || record.corners_used < 4) continue;
    dsp::SurfaceSample<double> at;
    const auto model = record.model.cast<double>();
    const auto t = dsp::intersect(ray, model, dsp::Coefficients<double>(record.coefficients.cast<double>()), 0.0, at);
    ASSERT_TRUE(t.ok());
    ours.push_back((ray.origin + *t * ray.direction).z());
    theirs.push_back(std::stod(line.substr(1)));
  }
  EXPECT_GE(ours.size(), 300u);
  EXPECT_GE(correlation(ours, theirs), 0.97);
  std::printf("%zu of 500 frames, r = %.4f\n", ours.size(), correlation(ours, theirs));
}

}  // namespace
}  // namespace srd::firmware
