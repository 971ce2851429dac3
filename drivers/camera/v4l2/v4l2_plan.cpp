// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_plan.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>

#include "drivers/camera/v4l2/v4l2_apply.hpp"
#include "drivers/camera/v4l2/v4l2_controls.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

// What TRY_FMT makes of the settings; nothing when it refuses.
std::optional<V4l2Answer> tried(V4l2Port& port, const V4l2Settings& settings) {
  v4l2_format format = v4l2_format_request(settings);
  if (port.control(VIDIOC_TRY_FMT, &format) != 0) return std::nullopt;
  return read_answer(format, settings.multi_planar);
}

class Planner {
 public:
  Planner(V4l2Port& port, const V4l2Ask& ask) : port_(port), ask_(ask) {}

  Outcome<V4l2Plan> plan() {
    if (const int error = port_.open(ask_.path.c_str()); error != 0) return failed(V4l2Step::kOpen, error);
    if (const int error = identify(port_, plan_.identity); error != 0) return failed(V4l2Step::kCapability, error);
    if (!plan_.identity.captures() || !plan_.identity.streams())
      return Problem{Exit::kDevice,
                     "not a camera",
                     ask_.path,
                     "a video capture device that streams",
                     plan_.identity.kind() + ", " + plan_.identity.card,
                     "srd-node --list-cameras shows what is there"};
    V4l2Settings& settings = plan_.settings;
    settings.multi_planar = plan_.identity.multi_planar();
    settings.buffers = ask_.buffers;
    if (auto done = look_at_input(); !done) return done.error();
    offers_ = offers_of(port_, settings.buffer_type());
    if (auto done = choose_format(); !done) return done.error();
    if (auto done = choose_rate(); !done) return done.error();
    V4l2ControlPlan controls = plan_controls(port_, {ask_.exposure_us, ask_.gain, ask_.sharpness, ask_.focus}, settings);
    plan_.concerns = controls.concerns;
    plan_.exposure_ns = controls.exposure_ns;
    for (std::string& note : controls.notes) plan_.notes.push_back(std::move(note));
    if (plan_.format.compressed())
      plan_.concerns.push_back("frames are compressed (MJPG): corners scatter more than in an uncompressed format");
    return std::move(plan_);
  }

 private:
  Problem failed(V4l2Step step, int error) const { return problem_of({step, error}, ask_.path); }

  Problem refused(std::string what, std::string expected, std::string advice) const {
    return {Exit::kDevice,
            std::move(what),
            ask_.path,
            std::move(expected),
            "the device (" + plan_.identity.card + ") offers\n" + offers_text(offers_, "    ", input_size_),
            std::move(advice)};
  }

  Outcome<void> look_at_input() {
    int current = 0;
    if (port_.control(VIDIOC_G_INPUT, &current) != 0) return {};
    v4l2_input input;
    std::memset(&input, 0, sizeof input);
    input.index = static_cast<std::uint32_t>(current);
    if (port_.control(VIDIOC_ENUMINPUT, &input) != 0) return {};
    if ((input.status & V4L2_IN_ST_NO_SIGNAL) != 0) plan_.notes.push_back("no signal at the input");
    if ((input.capabilities & V4L2_IN_CAP_DV_TIMINGS) == 0) return {};
    plan_.settings.detect_timings = true;
    if (const int error = take_detected_timings(port_); error != 0) return failed(V4l2Step::kTimings, error);
    v4l2_dv_timings timings;
    std::memset(&timings, 0, sizeof timings);
    if (port_.control(VIDIOC_G_DV_TIMINGS, &timings) == 0)
      input_size_ = size_text(static_cast<int>(timings.bt.width), static_cast<int>(timings.bt.height)) + " (its input's)";
    return {};
  }

  // Whether the device has the format in the size wanted, and not only slower than asked where the rate is known.
  [[nodiscard]] bool fast_enough(const V4l2PixelFormat& format) const {
    if (!ask_.rate_hz) return true;
    for (const V4l2Offer& offer : offers_) {
      if (offer.code != format.code) continue;
      for (const V4l2Size& size : offer.sizes) {
        if (size.width != ask_.width * format.reduction() || size.height != ask_.height * format.reduction()) continue;
        if (size.rates.hz.empty() || size.rates.hz.back() > *ask_.rate_hz || same_rate(size.rates.hz.back(), *ask_.rate_hz))
          return true;
        return false;
      }
    }
    return true;
  }

  // The first format of the preferred order that the device has in the size wanted; where another one is as fast as asked and
  // it is not, that one.
  Outcome<void> choose_format() {
    V4l2Settings& settings = plan_.settings;
    bool named = false;  // the device has the format, in another size
    bool interlaced = false;
    for (const bool any_rate : {false, true})
      for (const V4l2PixelFormat& format : kV4l2Formats) {
        if (ask_.format != "auto" && ask_.format != format.name) continue;
        bool offered = false;
        for (const V4l2Offer& offer : offers_) offered = offered || offer.code == format.code;
        if (!offered) continue;
        named = true;
        if (!any_rate && !fast_enough(format)) continue;
        settings.code = format.code;
        settings.compressed = format.compressed();
        settings.width = ask_.width * format.reduction();
        settings.height = ask_.height * format.reduction();
        const auto answer = tried(port_, settings);
        if (!answer || answer->code != format.code) continue;
        if (answer->width != settings.width || answer->height != settings.height) continue;
        if (answer->field != V4L2_FIELD_NONE) {
          interlaced = true;
          continue;
        }
        v4l2_format set = v4l2_format_request(settings);
        if (const int error = port_.control(VIDIOC_S_FMT, &set); error != 0) return failed(V4l2Step::kFormat, error);
        plan_.format = format;
        return {};
      }
    if (interlaced)
      return refused("the camera gives interlaced fields", "whole frames (progressive)",
                     "choose another input or mode of the device");
    if (!named)
      return refused(
          "the camera has no usable pixel format",
          ask_.format == "auto" ? "one of " + v4l2_format_names().substr(6) : ask_.format,
          ask_.format == "auto" ? "this camera cannot be used" : "set camera.format to one that it offers, or \"auto\"");
    return refused("the camera does not offer this size",
                   size_text(ask_.width, ask_.height) + " in " + (ask_.format == "auto" ? "any format" : ask_.format),
                   "calibrate the camera in a size that it offers");
  }

  Outcome<void> choose_rate() {
    V4l2Settings& settings = plan_.settings;
    v4l2_streamparm rate;
    std::memset(&rate, 0, sizeof rate);
    rate.type = settings.buffer_type();
    const bool known = port_.control(VIDIOC_G_PARM, &rate) == 0;
    settings.set_interval = known && (rate.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
    if (settings.set_interval && ask_.rate_hz) {
      rate.parm.capture.timeperframe.numerator = 1000;
      rate.parm.capture.timeperframe.denominator = static_cast<std::uint32_t>(std::lround(*ask_.rate_hz * 1000));
      if (const int error = port_.control(VIDIOC_S_PARM, &rate); error != 0) return failed(V4l2Step::kInterval, error);
    }
    if (known && rate.parm.capture.timeperframe.numerator != 0) settings.interval = rate.parm.capture.timeperframe;
    if (settings.period_ns() > 0)
      plan_.rate_hz = static_cast<double>(settings.interval.denominator) / settings.interval.numerator;
    if (!ask_.rate_hz) return {};
    const std::string wanted = number_text(*ask_.rate_hz) + " Hz";
    if (plan_.rate_hz <= 0) {
      plan_.notes.push_back("frame rate cannot be set or read: " + wanted + " is taken for granted");
      settings.interval = {1000, static_cast<std::uint32_t>(std::lround(*ask_.rate_hz * 1000))};
      settings.set_interval = false;
      plan_.rate_hz = *ask_.rate_hz;
      return {};
    }
    if (same_rate(plan_.rate_hz, *ask_.rate_hz)) return {};
    const std::string given = number_text(std::round(plan_.rate_hz * 1000) / 1000) + " Hz";
    if (!ask_.rate_required) {
      plan_.notes.push_back("frame rate " + given + ", the device's own");
      return {};
    }
    return refused("the camera does not offer this frame rate",
                   wanted + " at " + size_text(ask_.width, ask_.height) + " " + std::string(plan_.format.name),
                   "it would run at " + given + ": set camera.frame_rate_hz to that, or to one that it offers");
  }

  V4l2Port& port_;
  const V4l2Ask& ask_;
  V4l2Plan plan_;
  std::vector<V4l2Offer> offers_;
  std::string input_size_;
};

}  // namespace

Outcome<V4l2Plan> plan_capture(V4l2Port& port, const V4l2Ask& ask) { return Planner(port, ask).plan(); }

}  // namespace srd
