// SPDX-License-Identifier: Apache-2.0
#include "firmware/stills/stills.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "drivers/camera/image_sketch.hpp"
#include "drivers/geometry/calibration.hpp"
#include "drivers/support/formatted.hpp"
#include "firmware/config/camera_factory.hpp"
#include "firmware/config/strobe_factory.hpp"
#include "firmware/stills/board_sight.hpp"
#include "firmware/stills/still_folder.hpp"

namespace srd::firmware {

namespace {

constexpr auto kPatience = std::chrono::milliseconds(100);  // between looks at whether to stop
constexpr int kFields = 10;                                 // along and across the image, as srd calibrate counts them

class StillTaker {
 public:
  StillTaker(int width, int height, StillFolder folder, const StillsOptions& options)
      : options_(options), folder_(std::move(folder)), sighter_(width, height), width_(width), height_(height) {}

  [[nodiscard]] bool trying() const { return trying_; }

  void ask(std::int64_t time_ns, bool automatic, std::int64_t patience_ns) {
    if (trying_ && (automatic || !automatic_)) return;  // a person goes before what is due by itself
    trying_ = true;
    automatic_ = automatic;
    until_ns_ = time_ns + patience_ns;
    before_.reset();
    reason_ = "it takes two frames to tell whether the board stands still";
  }

  // While a still is tried for: takes it, or gives up once its time is over.
  Outcome<void> look_at(const CameraFrame& frame) {
    if (!before_ || frame.time_ns - before_ns_ >= StillLimits::kBetweenNs) {
      auto taken = judge(frame);
      if (!taken) return taken.error();
      if (*taken) {
        trying_ = false;
        return {};
      }
    }
    if (frame.time_ns >= until_ns_) give_up();
    return {};
  }

  void give_up() {
    if (!trying_) return;
    trying_ = false;
    ++report.refused;
    report.last_reason = reason_;
    options_.notify("not taken " + reason_ + "\n");
  }

  StillsReport report;

 private:
  // False: reason_ says why not.
  Outcome<bool> judge(const CameraFrame& frame) {
    auto sight = sighter_.look_at(frame.image);
    if (!sight) {
      const ImageSketch sketch(frame.image);
      const std::string cause = sketch.fault() == ImageFault::kNone ? std::string() : ": " + sketch.diagnosis();
      reason_ = "there is no board of at least 4 x 4 corners in the image" + cause;
      before_.reset();
      return false;
    }
    const std::optional<BoardSight> before = std::exchange(before_, std::move(sight));
    const std::int64_t before_ns = std::exchange(before_ns_, frame.time_ns);
    if (!before) return false;  // the reason of an earlier pair stays
    const auto shift = shift_px(*before, *before_);
    if (!shift || *shift > options_.limits.most_shift_px) {
      const std::string far = shift ? formatted("%.2f px", *shift) : std::string("a third of a square or more");
      reason_ = "the board moves: " + far +
                formatted(" in %.0f ms, allowed are %.2f px. Prop it up, or hold it still",
                          static_cast<double>(frame.time_ns - before_ns) / 1e6, options_.limits.most_shift_px);
      return false;
    }
    if (before_->blur_px > options_.limits.most_blur_px) {
      reason_ = formatted("the image is not sharp: edges of %.2f px blur, allowed are %.2f px. ", before_->blur_px,
                          options_.limits.most_blur_px) +
                "Turn the focus, close the aperture, or shorten camera.exposure_us";
      return false;
    }
    const bool same_place = still_ && shift_px(*still_, *before_);
    if (same_place && automatic_) {
      reason_ = "the board is where it was in " + name_ + ": move and tilt it, another view tells more";
      return false;
    }
    auto name = folder_.add(frame.image);
    if (!name) return name.error();
    const std::string note = same_place ? ", where it was in " + name_ : "";
    name_ = *name;
    still_ = before_;
    ++report.taken;
    options_.notify("still     " + name_ +
                    formatted(": %d x %d corners, %.2f px blur, moved %.2f px, ", before_->columns, before_->rows,
                              before_->blur_px, *shift) +
                    formatted("%.0f %% of the image covered so far", covered()) + note + "\n");
    return true;
  }

  double covered() {
    for (const SightedCorner& corner : before_->corners) {
      const auto at = [](double px, int size) { return std::clamp(static_cast<int>(px * kFields / size), 0, kFields - 1); };
      fields_[static_cast<std::size_t>(at(corner.v, height_) * kFields + at(corner.u, width_))] = true;
    }
    return 100.0 * static_cast<double>(std::count(fields_.begin(), fields_.end(), true)) / (kFields * kFields);
  }

  const StillsOptions& options_;
  StillFolder folder_;
  BoardSighter sighter_;
  int width_, height_;
  std::array<bool, static_cast<std::size_t>(kFields* kFields)> fields_{};
  bool trying_ = false, automatic_ = false;
  std::int64_t until_ns_ = 0, before_ns_ = 0;
  std::optional<BoardSight> before_;  // the board in the frame before
  std::optional<BoardSight> still_;   // in the last still, whose name is name_
  std::string name_, reason_;
};

// Where no frame comes, once: what a person would wait for in vain.
class Silence {
 public:
  explicit Silence(const StillsOptions& options) : options_(options) {}
  void frame() { since_ = std::chrono::steady_clock::now(); }
  void none(bool away) {
    if (told_ || std::chrono::steady_clock::now() - since_ < std::chrono::seconds(3)) return;
    told_ = true;
    options_.notify(away ? "note      the camera is away, being called\n"
                         : "note      no frame comes: the cable, the trigger, another program that has the camera\n");
  }
  void dark(const std::string& text) {
    if (told_ || std::chrono::steady_clock::now() - since_ < std::chrono::seconds(3)) return;
    told_ = true;
    options_.notify("note      " + text + "\n");
  }

 private:
  const StillsOptions& options_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  bool told_ = false;
};

Outcome<CameraPlace> place_of(const NodeConfig& config) {
  CameraPlace place;
  if (!config.camera->live()) return place;
  place.width = config.live.width.value_or(0);
  place.height = config.live.height.value_or(0);
  if (place.width > 0 && place.height > 0) return place;
  const std::filesystem::path file = config.file.parent_path() / config.calibration;
  std::error_code error;
  if (!config.calibration.empty() && std::filesystem::exists(file, error)) {
    const auto read = read_calibration(file);
    if (!read) return read.error();
    place.width = read->image_width;
    place.height = read->image_height;
  }
  if (place.width > 0 && place.height > 0) return place;
  return Problem{Exit::kUsage,
                 "the size of the camera's images is missing",
                 config.file.string(),
                 "camera.width_px and camera.height_px",
                 "neither these nor a calibration with a size",
                 "one of the sizes that srd-node --list-cameras shows; the calibration is then of this size"};
}

}  // namespace

Outcome<StillsReport> take_stills(Camera& camera, LitFrames& frames, const StillsOptions& options,
                                  const std::atomic<bool>& stop) {
  auto folder = StillFolder::open(options.folder);
  if (!folder) return folder.error();
  StillTaker taker(camera.width(), camera.height(), std::move(*folder), options);
  Silence silence(options);
  const auto interval_ns = static_cast<std::int64_t>(std::llround(options.every_s.value_or(0) * 1e9));
  const std::int64_t automatic_patience_ns = std::min(StillLimits::kPatienceNs, interval_ns);
  std::optional<std::int64_t> next_ns;  // that a still is due by itself
  bool asked = false;
  std::uint64_t dark = 0;
  CameraFrame frame;
  while (!stop.load(std::memory_order_relaxed) && (options.count == 0 || taker.report.taken < options.count)) {
    const Capture got = frames.next(frame, kPatience);
    asked = options.asked() || asked;
    if (got == Capture::kEnd) {
      taker.give_up();
      break;
    }
    if (got != Capture::kFrame) {
      silence.none(got == Capture::kDisconnected);
      continue;
    }
    if (!frames.lit(frame)) {
      silence.dark(frames.none_of(++dark));
      frames.give_back(frame);
      continue;
    }
    silence.frame();
    if (!next_ns) next_ns = frame.time_ns;
    if (asked) {
      taker.ask(frame.time_ns, false, StillLimits::kPatienceNs);
      asked = false;
    } else if (interval_ns > 0 && !taker.trying() && frame.time_ns >= *next_ns) {
      taker.ask(frame.time_ns, true, automatic_patience_ns);
    }
    const bool was_trying = taker.trying();
    auto looked = was_trying ? taker.look_at(frame) : Outcome<void>();
    if (was_trying && !taker.trying()) next_ns = frame.time_ns + interval_ns;
    frames.give_back(frame);
    if (!looked) return looked.error();
  }
  return taker.report;
}

Outcome<StillsReport> run_stills(const NodeConfig& config, const StillsOptions& options, const std::atomic<bool>& stop) {
  if (!config.camera)
    return Problem{Exit::kUsage, "no camera", config.file.string(), "camera.source, or --camera KIND:ARG", "neither", ""};
  auto scene = scene_of(config);
  if (!scene) return scene.error();
  const auto place = place_of(config);
  if (!place) return place.error();
  auto camera = make_camera(config, *scene, *place);
  if (!camera) return camera.error();
  if (auto started = (*camera)->start(); !started) return started.error();
  options.notify((*camera)->summary());
  auto strobe = open_strobe(config, **camera);
  if (!strobe) return strobe.error();
  if (*strobe) (*strobe)->start();
  LitFrames frames(**camera, strobe->get(), config.strobe);
  auto report = take_stills(**camera, frames, options, stop);
  if (*strobe) (*strobe)->stop();
  (*camera)->stop();
  if (!report) return report;
  options.notify(formatted("%llu taken, %llu not taken, in ", static_cast<unsigned long long>(report->taken),
                           static_cast<unsigned long long>(report->refused)) +
                 options.folder.string() + "\n");
  if (report->taken == 0 && !stop)
    return Problem{Exit::kInput,
                   "no still is taken, and the camera has ended",
                   config.camera->text(),
                   "a board that is sharp and stands still, and --every or a key that asks",
                   report->last_reason.empty() ? "nobody asked for one" : report->last_reason,
                   ""};
  return report;
}

}  // namespace srd::firmware
