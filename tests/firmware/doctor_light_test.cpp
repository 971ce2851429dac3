// SPDX-License-Identifier: Apache-2.0
// The doctor at a flume that is dark but for the strobe, in real time: camera and lamp of a test.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware/doctor/doctor.hpp"
#include "firmware/doctor/pulse_check.hpp"
#include "tests/fakes/live_camera.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kPeriod = 10'000'000, kExposure = 8'000'000, kReadout = 1'000'000;
constexpr double kRate = 100;

// A line that remembers when it was on.
class Switch {
 public:
  void set(bool on) {
    const std::scoped_lock lock(mutex_);
    if (on == on_) return;
    on_ = on;
    edges_.push_back(clock_.now_ns());  // on, off, on, ..
  }
  [[nodiscard]] bool on() const {
    const std::scoped_lock lock(mutex_);
    return on_;
  }
  // Whether it was switched on within.
  [[nodiscard]] bool rose(std::int64_t begin_ns, std::int64_t end_ns) const {
    const std::int64_t first = first_rise(begin_ns);
    return first >= 0 && first < end_ns;
  }
  // At or after a time; -1: not yet.
  [[nodiscard]] std::int64_t first_rise(std::int64_t from_ns) const {
    const std::scoped_lock lock(mutex_);
    for (std::size_t i = 0; i < edges_.size(); i += 2)
      if (edges_[i] >= from_ns) return edges_[i];
    return -1;
  }

 private:
  mutable std::mutex mutex_;
  SystemStrobeClock clock_;
  std::vector<std::int64_t> edges_;
  bool on_ = false;
};

class SwitchedLine final : public OutputLine {
 public:
  explicit SwitchedLine(Switch& line) : line_(line) {}
  ~SwitchedLine() override { line_.set(false); }
  void set(bool on) noexcept override { line_.set(on); }
  [[nodiscard]] std::uint64_t faults() const noexcept override { return 0; }

 private:
  Switch& line_;
};

// Where the camera's exposure lies, as it says and as it is, ns from its start.
struct Exposure {
  std::int64_t told_ns = kExposure;
  std::int64_t begin_ns = 0, end_ns = kExposure;
};

// A live camera: what it sees where the lamp shone in its exposure, else black. It runs by itself, or by its trigger.
class DarkFlume final : public fakes::LiveCamera {
 public:
  struct Lines {
    Switch lamp, trigger;
  };
  DarkFlume(int width, int height, std::vector<std::uint8_t> lit, Lines& lines, bool triggered, ClockId clock,
            const Exposure& exposure)
      : LiveCamera(width, height),
        lit_(std::move(lit)),
        dark_(lit_.size(), 2),
        lines_(lines),
        triggered_(triggered),
        stamps_(clock),
        exposure_(exposure) {}
  Outcome<void> start() override {
    next_ns_ = clock_.now_ns();
    sequence_ = 0;
    return {};
  }
  Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override {
    const std::int64_t end = clock_.now_ns() + timeout.count();
    std::int64_t begin = next_ns_;
    if (triggered_) {
      while ((begin = lines_.trigger.first_rise(next_ns_)) < 0) {
        if (clock_.now_ns() >= end) return Capture::kTimeout;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      next_ns_ = begin + 1;
    } else {
      next_ns_ += kPeriod;
    }
    clock_.sleep_until(begin + kExposure + kReadout);
    frame = {};
    frame.image = {(lines_.lamp.rose(begin + exposure_.begin_ns, begin + exposure_.end_ns) ? lit_ : dark_).data(), width(),
                   height(), width()};
    frame.sequence = sequence_++;
    frame.time_ns = begin + exposure_.told_ns / 2;
    frame.clock = stamps_;
    return Capture::kFrame;
  }
  FrameTiming timing() const override {
    FrameTiming timing;
    timing.exposure_ns = exposure_.told_ns;
    return timing;
  }

 private:
  SystemStrobeClock clock_;
  std::vector<std::uint8_t> lit_, dark_;
  Lines& lines_;
  bool triggered_;
  ClockId stamps_;
  Exposure exposure_;
  std::int64_t next_ns_ = 0;
  std::uint64_t sequence_ = 0;
};

class DoctorLight : public ::testing::Test {
 protected:
  // The findings on the simulator's flume with its light replaced.
  void examine(StrobeMode mode, const char* pattern, ClockId clock = ClockId::kMonotonic) {
    auto config = NodeConfig::parse(
        "[camera]\nsource = \"simulator\"\nrate = \"max\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n",
        "node.toml");
    ASSERT_TRUE(config.ok()) << config.error().text();
    config->frame_rate_hz = kRate;
    StrobeSection& section = config->strobe;
    section.mode = mode;
    section.line = "17";
    section.jitter_us = 5000;  // whatever else this machine does
    section.pattern = *StrobePattern::parse(pattern);
    auto instrument = make_instrument(*config);
    ASSERT_TRUE(instrument.ok()) << instrument.error().text();
    const bool triggered = mode == StrobeMode::kTrigger;
    instrument->camera = std::make_unique<DarkFlume>(instrument->width, instrument->height, picture(*instrument->camera),
                                                     lines_, triggered, clock, exposure_);
    const auto light = [&](const Camera& camera) -> Outcome<std::unique_ptr<Strobe>> {
      return std::make_unique<Strobe>(
          section, strobe_timing(section, camera.timing(), kRate), Region{}, std::make_unique<SwitchedLine>(lines_.lamp),
          triggered ? std::make_unique<SwitchedLine>(lines_.trigger) : nullptr, std::make_unique<SystemStrobeClock>());
    };
    DoctorOptions options;
    options.camera_time = camera_time_;
    options.stop = &stop_;
    check_camera(*config, *instrument, light, options, diagnosis_);
    EXPECT_FALSE(lines_.lamp.on());
    EXPECT_FALSE(lines_.trigger.on());
  }

  std::vector<std::uint8_t> picture(Camera& simulator) {
    EXPECT_TRUE(simulator.start().ok());
    CameraFrame frame;
    EXPECT_EQ(simulator.next(frame, std::chrono::seconds(10)), Capture::kFrame);
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < frame.image.height; ++v)
      pixels.insert(pixels.end(), frame.image.row(v), frame.image.row(v) + frame.image.width);
    simulator.give_back(frame);
    simulator.stop();
    double sum = 0;
    for (const std::uint8_t pixel : pixels) sum += pixel;
    mean_ = sum / static_cast<double>(pixels.size());
    return pixels;
  }

  const Finding& about(const std::string& subject) {
    static const Finding kNone{Verdict::kFail, "", "no finding"};
    for (const Finding& finding : diagnosis_.findings())
      if (finding.subject == subject) return finding;
    ADD_FAILURE() << "nothing was found about " << subject;
    return kNone;
  }

  void expect_light_and_pattern() {
    const Finding &light = about("light"), &pattern = about("pattern");
    EXPECT_EQ(light.verdict, Verdict::kOk) << light.text();
    double grey = 0;
    EXPECT_EQ(std::sscanf(light.found.c_str(), "mean grey level %lf", &grey), 1) << light.text();
    EXPECT_GT(grey, 0.9 * mean_) << "dark frames are no light that is missing";
    EXPECT_EQ(pattern.verdict, Verdict::kOk) << pattern.text();
  }

  DarkFlume::Lines lines_;
  Exposure exposure_;
  std::chrono::milliseconds camera_time_{5000};  // it is used up only when nothing is found
  std::atomic<bool> stop_{false};
  Diagnosis diagnosis_;
  double mean_ = 0;
};

TEST_F(DoctorLight, SeesThePatternByTheStrobeThatFollowsTheCamera) {
  examine(StrobeMode::kFollow, "LD");
  expect_light_and_pattern();
  EXPECT_EQ(about("pulses").found.find("they lie outside"), std::string::npos) << about("pulses").text();
}

// 4 ms for pulses of 0.5 ms that may be 5 ms late; then 0.4 ms, which no pulse fits into.
TEST_F(DoctorLight, SaysThatTheExposureIsTooShortForThePulses) {
  camera_time_ = std::chrono::milliseconds(500);
  for (const auto& [told_ns, words] : {std::pair{4'000'000, "4000 us: too short for"}, {400'000, "400 us: shorter than"}}) {
    diagnosis_ = Diagnosis();
    exposure_.told_ns = told_ns;
    examine(StrobeMode::kFollow, "L");
    const Finding& finding = about("exposure");
    EXPECT_EQ(finding.verdict, Verdict::kFail) << finding.text();
    EXPECT_NE(finding.found.find(words), std::string::npos) << finding.text();
    EXPECT_NE(finding.found.find("= 5500 us"), std::string::npos) << finding.text();
    EXPECT_NE(finding.advice.find("camera.exposure_us of at least 5500"), std::string::npos) << finding.text();
    EXPECT_EQ(diagnosis_.exit(), Exit::kDevice);
  }
}

// A camera whose stamps mark something else than is believed: it exposes where the pulses never are.
TEST_F(DoctorLight, SaysThatThePulsesLieOutsideOfTheExposure) {
  camera_time_ = std::chrono::milliseconds(1500);
  exposure_.begin_ns = kExposure;
  exposure_.end_ns = kExposure + kReadout;
  examine(StrobeMode::kFollow, "LD");
  const Finding& finding = about("pulses");
  EXPECT_EQ(finding.verdict, Verdict::kWarn) << finding.text();
  EXPECT_NE(finding.found.find("outside of the exposure"), std::string::npos) << finding.text();
  EXPECT_NE(finding.advice.find("camera.stamp"), std::string::npos) << finding.text();
}

// All rows of a rolling shutter integrate together for the exposure less the readout.
TEST(PulseCheck, TakesTheReadoutOfARollingShutterFromTheExposure) {
  StrobeSection section;
  section.pulse_us = 500;
  section.jitter_us = 200;
  FrameTiming timing;
  timing.exposure_ns = 1'000'000;
  timing.readout_ns = 400'000;
  Diagnosis global, rolling, unknown;
  EXPECT_TRUE(check_exposure(section, timing, global));
  EXPECT_TRUE(global.findings().empty());
  timing.shutter = Shutter::kRolling;
  EXPECT_FALSE(check_exposure(section, timing, rolling));
  EXPECT_NE(rolling.findings().front().found.find("together for 600 us"), std::string::npos);
  EXPECT_NE(rolling.findings().front().advice.find("at least 1100"), std::string::npos);
  timing.exposure_ns = 0;
  EXPECT_FALSE(check_exposure(section, timing, unknown));
  EXPECT_EQ(unknown.findings().front().verdict, Verdict::kWarn);
}

TEST(PulseCheck, TellsWhatTheRunOfTheStrobeShows) {
  StrobeSection section;
  section.pattern = *StrobePattern::parse("LD");
  StrobeReport report;
  report.pulses = 100;
  const auto finding = [&](const StrobedLevels& levels) {
    Diagnosis diagnosis;
    check_pulses(section, report, levels, diagnosis);
    return diagnosis.findings().front();
  };
  EXPECT_EQ(finding({90, 12}).verdict, Verdict::kOk);
  EXPECT_EQ(finding({14, 12}).verdict, Verdict::kWarn);
  EXPECT_EQ(finding({14, {}}).verdict, Verdict::kOk) << "no dark frames to compare";
  report.spilled = 7;
  EXPECT_NE(finding({90, 12}).found.find("7 of 100 pulses ended after the exposure"), std::string::npos);
  report.shift = 1;
  EXPECT_NE(finding({90, 12}).found.find("1 exposures later"), std::string::npos);
}

TEST_F(DoctorLight, SeesThePatternOfACameraThatWaitsForTriggers) {
  examine(StrobeMode::kTrigger, "L");
  expect_light_and_pattern();
}

// Stamps of a clock that is not this board's: the strobe never gets in step.
TEST_F(DoctorLight, WithoutTheStrobesLightItIsTheStrobeThatIsTold) {
  camera_time_ = std::chrono::milliseconds(500);
  examine(StrobeMode::kFollow, "L", ClockId::kUnknown);
  for (const char* subject : {"light", "pattern"}) {
    const Finding& finding = about(subject);
    EXPECT_EQ(finding.verdict, Verdict::kWarn);
    EXPECT_NE(finding.found.find("none of "), std::string::npos) << finding.text();
    EXPECT_NE(finding.found.find("unlocked"), std::string::npos) << finding.text();
    EXPECT_NE(finding.advice.find("camera.stamp"), std::string::npos) << finding.text();
  }
  EXPECT_EQ(diagnosis_.exit(), Exit::kDone);
}

// ClockId::kMonotonic: while frames are watched; kUnknown: while the pattern is looked for, which takes all the time there is.
TEST_F(DoctorLight, ToldToStopItEndsSoonAndItsLinesAreOff) {
  camera_time_ = std::chrono::minutes(2);
  for (const auto& [clock, part] : {std::pair{ClockId::kMonotonic, "frames"}, {ClockId::kUnknown, "pattern"}}) {
    stop_ = false;
    diagnosis_ = Diagnosis();
    const bool watched = clock == ClockId::kUnknown;
    std::thread person([&, delay = std::chrono::milliseconds(watched ? 2000 : 500)] {
      std::this_thread::sleep_for(delay);
      stop_ = true;
    });
    const auto begin = std::chrono::steady_clock::now();
    examine(StrobeMode::kFollow, "L", clock);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
    person.join();
    for (const Finding& finding : diagnosis_.findings()) EXPECT_NE(finding.subject, part) << finding.text();
  }
}

}  // namespace
}  // namespace srd::firmware
