// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "drivers/camera/libcamera/libcamera_environment.hpp"
#include "drivers/support/formatted.hpp"
#include "firmware/config/strobe_factory.hpp"
#include "firmware/doctor/doctor.hpp"
#include "firmware/doctor/lit_frames.hpp"
#include "firmware/doctor/pulse_check.hpp"
#include "firmware/doctor/rig_check.hpp"
#include "firmware/doctor/sharpening_check.hpp"

namespace srd::firmware {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kFrames = 100;
constexpr int kSearched = 10;                               // frames in which the pattern is looked for
constexpr auto kRigTime = std::chrono::seconds(10);         // until the rig's second look
constexpr auto kPatience = std::chrono::milliseconds(100);  // between looks at whether to stop
constexpr int kStep = 4;                                    // every fourth pixel is enough to judge the light
constexpr double kDark = 30, kBright = 225, kMaxSaturated = 0.01;
constexpr double kRateTolerance = 0.02;
constexpr double kMaxConversion = 0.5;  // of a frame's time: the capture thread takes the next frame late beyond
constexpr const char* kFramesAdvice =
    "the cable, the trigger if the sensor waits for one, and another program that has the camera";
constexpr const char* kStrobeAdvice =
    "a rate that the camera keeps (camera.frame_rate_hz), camera.stamp, real-time priority (below), a longer strobe.jitter_us";

struct Seen {
  std::uint64_t frames = 0, bad = 0, gaps = 0, away = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t first_sequence = 0, next_sequence = 0;
  std::uint32_t exposure_us = 0;  // the shortest that a frame reported; 0: none did
  double grey = 0, saturated = 0, pixels = 0;
  double dark_grey = 0, dark_pixels = 0;  // of frames that are dark on purpose

  void add(const CameraFrame& frame) {
    if (frames == 0) {
      first_ns = frame.time_ns;
      first_sequence = frame.sequence;
    } else if (frame.sequence > next_sequence) {
      gaps += frame.sequence - next_sequence;
    }
    next_sequence = frame.sequence + 1;
    if (frame.exposure_us > 0) exposure_us = exposure_us == 0 ? frame.exposure_us : std::min(exposure_us, frame.exposure_us);
    last_ns = frame.time_ns;
    ++frames;
  }
  void look_at(const GrayView& image) {
    for (int v = 0; v < image.height; v += kStep)
      for (int u = 0; u < image.width; u += kStep) {
        const std::uint8_t level = image.row(v)[u];
        grey += level;
        saturated += level == 255 ? 1 : 0;
        pixels += 1;
      }
  }
  void look_at_dark(const GrayView& image) {
    for (int v = 0; v < image.height; v += kStep)
      for (int u = 0; u < image.width; u += kStep) {
        dark_grey += image.row(v)[u];
        dark_pixels += 1;
      }
  }
  [[nodiscard]] StrobedLevels levels() const {
    StrobedLevels levels;
    if (pixels > 0) levels.lit = grey / pixels;
    if (dark_pixels > 0) levels.dark = dark_grey / dark_pixels;
    return levels;
  }
  // Of the frames' own times; 0: not known.
  [[nodiscard]] double rate_hz() const {
    const std::uint64_t steps = next_sequence - first_sequence;
    return steps < 2 || last_ns <= first_ns ? 0
                                            : static_cast<double>(steps - 1) * 1e9 / static_cast<double>(last_ns - first_ns);
  }
};

Seen watch(LitFrames& frames, std::chrono::milliseconds time, const DoctorOptions& options) {
  Seen seen;
  CameraFrame frame;
  const auto end = Clock::now() + time;
  for (bool over = false; !over && !options.stopping() && seen.frames + seen.bad < kFrames && Clock::now() < end;) {
    switch (frames.next(frame, kPatience)) {
      case Capture::kFrame:
        seen.add(frame);
        if (frames.lit(frame)) seen.look_at(frame.image);
        if (frame.strobe == StrobePhase::kDark) seen.look_at_dark(frame.image);
        frames.give_back(frame);
        break;
      case Capture::kBadFrame: ++seen.bad; break;
      case Capture::kDisconnected: ++seen.away; break;
      case Capture::kTimeout: break;
      case Capture::kEnd: over = true; break;
    }
  }
  return seen;
}

void judge_frames(const Seen& seen, bool live, double wanted_hz, Diagnosis& diagnosis) {
  const double rate = seen.rate_hz();
  const std::string found =
      formatted("%llu frames, %.2f frames/s, %llu missing, %llu unusable", static_cast<unsigned long long>(seen.frames), rate,
                static_cast<unsigned long long>(seen.gaps), static_cast<unsigned long long>(seen.bad));
  if (seen.frames == 0) {
    diagnosis.fail(Exit::kDevice, "frames", seen.away > 0 ? "none: the camera is away" : found,
                   live ? kFramesAdvice : "the images of the recording");
  } else if (seen.gaps + seen.bad + seen.away > 0) {
    diagnosis.warn("frames", found, "a shorter cable, more buffers (camera.buffers), a lower rate, or a faster disk");
  } else if (live && rate > 0 && std::abs(rate - wanted_hz) > kRateTolerance * wanted_hz) {
    diagnosis.warn("frames", found + formatted(", asked were %.2f", wanted_hz),
                   "a rate that the camera offers (--list-cameras), or a shorter exposure");
  } else {
    diagnosis.ok("frames", found);
  }
}

// What the capture thread does to each frame: its time is a part of the frame's.
void judge_conversion(const Camera& camera, double rate_hz, Diagnosis& diagnosis) {
  const double took = std::chrono::duration<double>(camera.conversion_time()).count();
  if (!(took > 0) || !(rate_hz > 0)) return;
  const std::string found =
      formatted("%.2f ms of the %.2f ms between two frames (%.0f %%)", 1e3 * took, 1e3 / rate_hz, 100 * took * rate_hz);
  if (took * rate_hz > kMaxConversion)
    diagnosis.warn("conversion to grey", found,
                   "a lower camera.frame_rate_hz, a smaller size, or a format that is grey already");
  else
    diagnosis.ok("conversion to grey", found);
}

void judge_libcamera(bool trigger_input, Diagnosis& diagnosis) {
  for (const LibcameraSetting& setting : libcamera_settings(trigger_input))
    if (setting.advice.empty())
      diagnosis.ok(setting.subject, setting.found);
    else
      diagnosis.warn(setting.subject, setting.found, setting.advice);
}

void judge_stamps(const CameraCounters& faults, Diagnosis& diagnosis) {
  const std::uint64_t bad = faults.bad_stamps.load(std::memory_order_relaxed);
  if (bad == 0) return;
  diagnosis.warn("stamps", formatted("%llu frames with a time that cannot be true", static_cast<unsigned long long>(bad)),
                 "another driver or kernel for this camera: those frames carry the time at which they arrived");
}

void judge_image(const std::vector<std::string>& concerns, Diagnosis& diagnosis) {
  for (const std::string& concern : concerns)
    diagnosis.warn("image", concern,
                   "turn that control by hand (v4l2-ctl, the camera's own menu), or a camera without it: "
                   "what changes edges or the lens moves the corners");
}

void judge_light(const Seen& seen, const LitFrames& frames, Diagnosis& diagnosis) {
  if (seen.frames == 0) return;
  if (seen.pixels == 0) {
    diagnosis.warn("light", frames.none_of(seen.frames), kStrobeAdvice);
    return;
  }
  const double mean = seen.grey / seen.pixels, saturated = seen.saturated / seen.pixels;
  const std::string found = formatted("mean grey level %.0f, %.1f %% saturated", mean, 100 * saturated);
  if (mean < kDark)
    diagnosis.warn(
        "light", found + ": too dark",
        "a longer exposure (camera.exposure_us), more gain or light; the lens cap; pulses of the strobe that lie outside of "
        "the exposure (strobe.pattern with a D tells)");
  else if (mean > kBright || saturated > kMaxSaturated)
    diagnosis.warn("light", found + ": too bright", "a shorter exposure (camera.exposure_us), less gain, no reflections");
  else
    diagnosis.ok("light", found);
}

const char* advice_for(dsp::TrackStatus status) {
  switch (status) {
    case dsp::TrackStatus::kAmbiguous: return "a better surface.guess_mm, or pattern.first_square";
    case dsp::TrackStatus::kPoorFit: return "geometry.pose and the index of water; surface.guess_mm";
    case dsp::TrackStatus::kInconsistent:
      return "nothing that moves over the pattern, no glare, an exposure that freezes the waves";
    case dsp::TrackStatus::kInterlaced: return "a progressive mode of the camera: it delivers interlaced pictures";
    case dsp::TrackStatus::kSolverFailed: return "fewer surface.parameters, or more corners in the image";
    case dsp::TrackStatus::kTooFewCorners: return "more of the pattern in the image, less glare";
    default: return "aim and focus the camera, uncover the pattern; pattern and detector.threshold in the configuration";
  }
}

void find_pattern(const NodeConfig& config, Instrument& instrument, LitFrames& frames, const DoctorOptions& options,
                  Diagnosis& diagnosis) {
  Camera& camera = *instrument.camera;
  // A recording may be over, and begins anew. A live camera goes on, so that the strobe stays in step with it.
  if (!camera.live()) {
    camera.stop();
    if (!camera.start().ok()) return;  // it did a moment ago: the frames have told
  }
  CameraFrame frame;
  dsp::TrackStatus status = dsp::TrackStatus::kNoPattern;
  const int corners = instrument.tracker->pattern().size();
  const auto end = Clock::now() + options.camera_time;
  std::uint64_t came = 0;
  int searched = 0;
  bool found = false;
  RigCheck rig(config, instrument);
  // A rig that seems to have moved is looked at once more, and has time of its own for that.
  std::optional<Clock::time_point> rig_end;
  while (!options.stopping()) {
    const bool searching = !found && searched < kSearched && Clock::now() < end;
    if (!searching) {
      if (!rig.undecided()) break;
      if (!rig_end) rig_end = Clock::now() + kRigTime;
      if (Clock::now() >= *rig_end) break;
    }
    const Capture got = frames.next(frame, kPatience);
    if (got == Capture::kEnd) break;
    if (got != Capture::kFrame) continue;
    ++came;
    if (!frames.lit(frame)) {
      frames.give_back(frame);
      continue;
    }
    rig.look(frame.image, frame.time_ns);
    if (!searching) {
      frames.give_back(frame);
      continue;
    }
    if (searched++ == 0) {
      const dsp::Pattern& pattern = instrument.tracker->pattern();
      check_sharpening(frame.image, config.tracker.detector, {pattern.rows(), pattern.columns()}, config.camera->kind,
                       diagnosis);
    }
    const dsp::FrameResult<float>& result = instrument.tracker->process(std::span(&frame.image, 1), frame.time_ns);
    frames.give_back(frame);
    status = result.status;
    found = result.has_surface();
    if (found)
      diagnosis.ok("pattern", formatted("%d of %d corners, %.3f px rms", result.estimate.corners_used, corners,
                                        static_cast<double>(result.estimate.reprojection_rms)));
  }
  if (options.stopping()) return;
  rig.tell(diagnosis);
  if (found) return;
  if (searched > 0)
    diagnosis.warn("pattern", "no surface in " + std::to_string(searched) + " frames", advice_for(status));
  else if (came > 0)
    diagnosis.warn("pattern", "not looked for, " + frames.none_of(came), kStrobeAdvice);
  else
    diagnosis.warn("pattern", "not looked for, no more frames came", kFramesAdvice);
}

}  // namespace

void check_camera(const NodeConfig& config, Instrument& instrument, const OpenLight& open_light, const DoctorOptions& options,
                  Diagnosis& diagnosis) {
  Camera& camera = *instrument.camera;
  const auto started = camera.start();
  if (config.camera->kind == "libcamera") judge_libcamera(config.live.trigger_input, diagnosis);
  if (!started) {
    diagnosis.fail("camera", started.error());
    return;
  }
  const std::string size = formatted("%d x %d", camera.width(), camera.height());
  const bool fits = camera.width() == instrument.width && camera.height() == instrument.height;
  if (fits)
    diagnosis.ok("camera", config.camera->text() + ", " + size);
  else
    diagnosis.fail(Exit::kInput, "camera",
                   size + ", and the calibration is of " + formatted("%d x %d", instrument.width, instrument.height),
                   "the calibration of this camera and mode");
  judge_image(camera.image_concerns(), diagnosis);
  {
    // As in a measurement, and to the end: a sensor that waits for triggers gives frames, and their light is what they will
    // have. A strobe that does not work is for the GPIO's own check.
    const auto strobe = open_light(camera);
    Strobe* const running = strobe.ok() ? strobe->get() : nullptr;
    if (running != nullptr) running->start();
    LitFrames frames(camera, running, config.strobe);
    const Seen seen = watch(frames, options.camera_time + frames.time_to_light(config.frame_rate_hz), options);
    if (!options.stopping()) {
      judge_frames(seen, camera.live(), config.frame_rate_hz, diagnosis);
      judge_conversion(camera, config.frame_rate_hz, diagnosis);
      judge_stamps(camera.faults(), diagnosis);
      judge_light(seen, frames, diagnosis);
      if (fits && seen.frames > 0) find_pattern(config, instrument, frames, options, diagnosis);
    }
    if (!options.stopping() && seen.frames > 0 && config.strobe.mode != StrobeMode::kOff && !config.strobe.line.empty() &&
        camera.live()) {
      FrameTiming timing = camera.timing();
      if (seen.exposure_us > 0) timing.exposure_ns = std::int64_t{1000} * seen.exposure_us;
      if (check_exposure(config.strobe, timing, diagnosis) && running != nullptr) {
        running->stop();
        check_pulses(config.strobe, running->report(), seen.levels(), diagnosis);
      }
    }
  }
  camera.stop();
}

void check_camera(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis) {
  auto instrument = make_instrument(config);
  if (!instrument) {
    diagnosis.fail("camera", instrument.error());
    return;
  }
  check_camera(
      config, *instrument, [&](const Camera& camera) { return open_strobe(config, camera); }, options, diagnosis);
}

}  // namespace srd::firmware
