// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "drivers/camera/v4l2/v4l2_line_time.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr std::int64_t kAbsoluteUnitUs = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE
constexpr std::int32_t kNeutralGamma = 100;    // of V4L2_CID_GAMMA on UVC devices

// A control that is there and can be written.
std::optional<v4l2_queryctrl> find(V4l2Port& port, std::uint32_t id) {
  v4l2_queryctrl control;
  std::memset(&control, 0, sizeof control);
  control.id = id;
  if (port.control(VIDIOC_QUERYCTRL, &control) != 0) return std::nullopt;
  if ((control.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0) return std::nullopt;
  return control;
}

std::optional<std::int32_t> value_of(V4l2Port& port, std::uint32_t id) {
  v4l2_control control{id, 0};
  if (port.control(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

bool has_menu_item(V4l2Port& port, std::uint32_t id, std::uint32_t item) {
  v4l2_querymenu menu;
  std::memset(&menu, 0, sizeof menu);
  menu.id = id;
  menu.index = item;
  return port.control(VIDIOC_QUERYMENU, &menu) == 0;
}

// The nearest value that the control can take.
std::int32_t nearest(const v4l2_queryctrl& control, double wanted) {
  const double low = control.minimum, high = control.maximum, step = std::max(1, control.step);
  const double inside = std::clamp(wanted, low, high);
  const double value = low + std::round((inside - low) / step) * step;
  return static_cast<std::int32_t>(value > high ? value - step : value);
}

std::string range_of(const v4l2_queryctrl& control, std::int64_t unit, const char* name) {
  return std::to_string(unit * control.minimum) + " to " + std::to_string(unit * control.maximum) +
         (*name == '\0' ? "" : std::string(" ") + name);
}

void plan_exposure(V4l2Port& port, std::optional<std::int64_t> exposure_us, V4l2Settings& settings, V4l2ControlPlan& plan) {
  const auto automatic = find(port, V4L2_CID_EXPOSURE_AUTO);
  const auto absolute = find(port, V4L2_CID_EXPOSURE_ABSOLUTE);
  const auto lines = absolute ? std::nullopt : find(port, V4L2_CID_EXPOSURE);
  const double line_ns = lines ? v4l2_line_time_ns(port, settings).value_or(0) : 0;  // 0: unknown
  if (!exposure_us) {
    const auto mode = automatic ? value_of(port, V4L2_CID_EXPOSURE_AUTO) : std::optional<std::int32_t>();
    const bool fixed = !mode || *mode == V4L2_EXPOSURE_MANUAL || *mode == V4L2_EXPOSURE_SHUTTER_PRIORITY;
    if (absolute && fixed)
      if (const auto value = value_of(port, V4L2_CID_EXPOSURE_ABSOLUTE)) plan.exposure_ns = 1000 * kAbsoluteUnitUs * *value;
    if (line_ns > 0 && fixed)
      if (const auto value = value_of(port, V4L2_CID_EXPOSURE)) plan.exposure_ns = std::llround(line_ns * *value);
    plan.notes.push_back(plan.exposure_ns > 0 ? "exposure left at " + std::to_string(plan.exposure_ns / 1000) + " us"
                         : fixed              ? "exposure left as it is, unknown"
                                              : "exposure left automatic: frames have no known exposure");
    return;
  }
  if (automatic) {
    // Manual holds the aperture too; a few devices only have shutter priority.
    for (const std::int32_t mode : {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY})
      if (has_menu_item(port, V4L2_CID_EXPOSURE_AUTO, static_cast<std::uint32_t>(mode))) {
        settings.add_control(V4L2_CID_EXPOSURE_AUTO, mode);
        break;
      }
  }
  // Else a long exposure would lower the frame rate.
  if (find(port, V4L2_CID_EXPOSURE_AUTO_PRIORITY)) settings.add_control(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
  const std::string wanted = std::to_string(*exposure_us) + " us";
  plan.exposure_ns = *exposure_us * 1000;
  if (absolute) {
    const std::int32_t value = nearest(*absolute, static_cast<double>(*exposure_us) / kAbsoluteUnitUs);
    settings.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, value);
    const std::int64_t us = kAbsoluteUnitUs * value;
    plan.exposure_ns = 1000 * us;
    if (us != *exposure_us)
      plan.notes.push_back("exposure " + std::to_string(us) + " us instead of " + wanted + ": the device takes " +
                           range_of(*absolute, kAbsoluteUnitUs, "us") + ", in steps of " +
                           std::to_string(kAbsoluteUnitUs * std::max(1, absolute->step)) + " us");
  } else if (lines && line_ns > 0) {
    // To the nearest line: less than a line's difference is the sensor's resolution, more is its range.
    const std::int32_t value = nearest(*lines, static_cast<double>(*exposure_us) * 1000 / line_ns);
    settings.add_control(V4L2_CID_EXPOSURE, value);
    plan.exposure_ns = std::llround(line_ns * value);
    const auto us = [&](double count) { return number_text(std::round(count * line_ns / 100) / 10); };
    if (std::abs(static_cast<double>(plan.exposure_ns) - static_cast<double>(*exposure_us) * 1000) >= 500)
      plan.notes.push_back("exposure " + us(value) + " us (" + std::to_string(value) + " lines) instead of " + wanted +
                           ": the device takes " + us(lines->minimum) + " to " + us(lines->maximum) + " us, in lines of " +
                           number_text(std::round(line_ns) / 1000) + " us");
  } else if (lines) {
    const auto now = value_of(port, V4L2_CID_EXPOSURE);
    plan.notes.push_back("exposure cannot be set in us: the device takes lines (" + range_of(*lines, 1, "") +
                         (now ? ", now " + std::to_string(*now) : std::string()) +
                         ") and does not tell how long a line is (pixel rate, horizontal blanking); left as it is, and frames "
                         "are timed as if it were " +
                         wanted);
  } else {
    plan.notes.push_back("exposure cannot be set: the device has no such control; frames are timed as if it were " + wanted);
  }
}

void plan_gain(V4l2Port& port, std::optional<double> gain, V4l2Settings& settings, V4l2ControlPlan& plan) {
  if (!gain) return;
  if (find(port, V4L2_CID_AUTOGAIN)) settings.add_control(V4L2_CID_AUTOGAIN, 0);
  for (const std::uint32_t id : {V4L2_CID_ANALOGUE_GAIN, V4L2_CID_GAIN})
    if (const auto control = find(port, id)) {
      const std::int32_t value = nearest(*control, *gain);
      settings.add_control(id, value);
      if (value != *gain)
        plan.notes.push_back("gain " + std::to_string(value) + " instead of " + number_text(*gain) +
                             ": the device takes whole numbers, " + range_of(*control, 1, ""));
      return;
    }
  plan.notes.push_back("gain cannot be set: the device has no such control");
}

// What the device itself would do to edges and grey levels.
void plan_image(V4l2Port& port, std::optional<double> sharpness, V4l2Settings& settings, V4l2ControlPlan& plan) {
  if (const auto control = find(port, V4L2_CID_SHARPNESS)) {
    const std::int32_t value = sharpness ? nearest(*control, *sharpness) : control->minimum;
    settings.add_control(V4L2_CID_SHARPNESS, value);
    if (sharpness && value != *sharpness)
      plan.notes.push_back("sharpness " + std::to_string(value) + " instead of " + number_text(*sharpness) +
                           ": the device takes whole numbers, " + range_of(*control, 1, ""));
  } else if (sharpness) {
    plan.notes.push_back("sharpness cannot be set: the device has no such control");
  }
  // Off is the least of each.
  for (const std::uint32_t id : {V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CID_BACKLIGHT_COMPENSATION, V4L2_CID_WIDE_DYNAMIC_RANGE,
                                 V4L2_CID_IMAGE_STABILIZATION, V4L2_CID_POWER_LINE_FREQUENCY})
    if (const auto control = find(port, id)) settings.add_control(id, control->minimum);
  if (const auto control = find(port, V4L2_CID_CONTRAST)) settings.add_control(V4L2_CID_CONTRAST, control->default_value);
  // UVC counts in hundredths: other devices' units have no known neutral value.
  if (const auto control = find(port, V4L2_CID_GAMMA);
      control && control->minimum <= kNeutralGamma && control->maximum >= 2 * kNeutralGamma)
    settings.add_control(V4L2_CID_GAMMA, nearest(*control, kNeutralGamma));
}

// A lens that moves makes another camera of it than the one that was calibrated.
void plan_focus(V4l2Port& port, std::optional<double> focus, V4l2Settings& settings, V4l2ControlPlan& plan) {
  const bool automatic = find(port, V4L2_CID_FOCUS_AUTO).has_value();
  if (automatic) settings.add_control(V4L2_CID_FOCUS_AUTO, 0);
  const auto absolute = find(port, V4L2_CID_FOCUS_ABSOLUTE);
  if (absolute && focus) {
    const std::int32_t value = nearest(*absolute, *focus);
    settings.add_control(V4L2_CID_FOCUS_ABSOLUTE, value);
    if (value != *focus)
      plan.notes.push_back("focus " + std::to_string(value) + " instead of " + number_text(*focus) +
                           ": the device takes whole numbers, " + range_of(*absolute, 1, ""));
  } else if (focus) {
    plan.notes.push_back("focus cannot be set: the device has no such control");
  } else if (absolute) {
    const auto now = value_of(port, V4L2_CID_FOCUS_ABSOLUTE);
    plan.notes.push_back("the lens stays where it is" + (now ? ", at focus " + std::to_string(*now) : std::string()) +
                         ": camera.focus holds the one that the camera was calibrated with");
  }
}

const char* name_of(std::uint32_t id) {
  switch (id) {
    case V4L2_CID_EXPOSURE_AUTO: return "manual exposure";
    case V4L2_CID_EXPOSURE_AUTO_PRIORITY: return "a fixed frame rate";
    case V4L2_CID_EXPOSURE_ABSOLUTE:
    case V4L2_CID_EXPOSURE: return "exposure";
    case V4L2_CID_AUTOGAIN: return "manual gain";
    case V4L2_CID_SHARPNESS: return "sharpness";
    case V4L2_CID_AUTO_WHITE_BALANCE: return "a fixed white balance";
    case V4L2_CID_BACKLIGHT_COMPENSATION: return "backlight compensation";
    case V4L2_CID_WIDE_DYNAMIC_RANGE: return "wide dynamic range";
    case V4L2_CID_IMAGE_STABILIZATION: return "image stabilisation";
    case V4L2_CID_POWER_LINE_FREQUENCY: return "the power-line filter";
    case V4L2_CID_CONTRAST: return "contrast";
    case V4L2_CID_GAMMA: return "gamma";
    case V4L2_CID_FOCUS_AUTO: return "manual focus";
    case V4L2_CID_FOCUS_ABSOLUTE: return "focus";
    default: return "gain";
  }
}

bool concerns_image(std::uint32_t id) {
  return id == V4L2_CID_SHARPNESS || id == V4L2_CID_AUTO_WHITE_BALANCE || id == V4L2_CID_BACKLIGHT_COMPENSATION ||
         id == V4L2_CID_WIDE_DYNAMIC_RANGE || id == V4L2_CID_IMAGE_STABILIZATION || id == V4L2_CID_POWER_LINE_FREQUENCY ||
         id == V4L2_CID_CONTRAST || id == V4L2_CID_GAMMA || id == V4L2_CID_FOCUS_AUTO || id == V4L2_CID_FOCUS_ABSOLUTE;
}

// Sets the values in their order, and leaves out those that the device refuses: they would be refused each time.
void leave_out_refused(V4l2Port& port, V4l2Settings& settings, V4l2ControlPlan& plan) {
  int kept = 0;
  for (int i = 0; i < settings.control_count; ++i) {
    const V4l2Control control = settings.controls[static_cast<std::size_t>(i)];
    v4l2_control set{control.id, control.value};
    if (const int error = port.control(VIDIOC_S_CTRL, &set); error != 0) {
      plan.notes.push_back(std::string(name_of(control.id)) + " cannot be set: " + std::strerror(error));
      if (concerns_image(control.id)) plan.concerns.push_back(plan.notes.back());
    } else {
      settings.controls[static_cast<std::size_t>(kept++)] = control;
    }
  }
  settings.control_count = kept;
}

// What the device has after all is set: some take a value and keep another. Read-only controls are looked at too.
void look_at_sharpness(V4l2Port& port, V4l2ControlPlan& plan) {
  v4l2_queryctrl control;
  std::memset(&control, 0, sizeof control);
  control.id = V4L2_CID_SHARPNESS;
  if (port.control(VIDIOC_QUERYCTRL, &control) != 0 || (control.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return;
  const auto value = value_of(port, V4L2_CID_SHARPNESS);
  if (value && *value > control.minimum)
    plan.concerns.push_back("sharpness is " + std::to_string(*value) + ", its least is " + std::to_string(control.minimum) +
                            ": the camera sharpens edges");
}

}  // namespace

V4l2ControlPlan plan_controls(V4l2Port& port, const V4l2ControlAsk& ask, V4l2Settings& settings) {
  V4l2ControlPlan plan;
  plan_exposure(port, ask.exposure_us, settings, plan);
  plan_gain(port, ask.gain, settings, plan);
  plan_image(port, ask.sharpness, settings, plan);
  plan_focus(port, ask.focus, settings, plan);
  leave_out_refused(port, settings, plan);
  look_at_sharpness(port, plan);
  return plan;
}

}  // namespace srd
