#include "drivers/camera/v4l2/v4l2_controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr std::int64_t kAbsoluteUnitUs = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE

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

void plan_exposure(V4l2Port& port, std::optional<std::int64_t> exposure_us, V4l2Settings& settings,
                   V4l2ControlPlan& plan) {
  const auto automatic = find(port, V4L2_CID_EXPOSURE_AUTO);
  const auto absolute = find(port, V4L2_CID_EXPOSURE_ABSOLUTE);
  const auto lines = find(port, V4L2_CID_EXPOSURE);
  if (!exposure_us) {
    const auto mode = automatic ? value_of(port, V4L2_CID_EXPOSURE_AUTO) : std::optional<std::int32_t>();
    const bool fixed = !mode || *mode == V4L2_EXPOSURE_MANUAL || *mode == V4L2_EXPOSURE_SHUTTER_PRIORITY;
    if (absolute && fixed)
      if (const auto value = value_of(port, V4L2_CID_EXPOSURE_ABSOLUTE))
        plan.exposure_ns = 1000 * kAbsoluteUnitUs * *value;
    plan.notes.push_back(plan.exposure_ns > 0
                             ? "exposure left at " + std::to_string(plan.exposure_ns / 1000) + " us"
                             : fixed ? "exposure left as it is, unknown" : "exposure left automatic: frames have no known exposure");
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
  } else if (lines) {
    const auto now = value_of(port, V4L2_CID_EXPOSURE);
    plan.notes.push_back("exposure cannot be set in us: the device takes lines (" + range_of(*lines, 1, "") +
                         (now ? ", now " + std::to_string(*now) : std::string()) +
                         "); left as it is, and frames are timed as if it were " + wanted);
  } else {
    plan.notes.push_back("exposure cannot be set: the device has no such control; frames are timed as if it were " +
                         wanted);
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

const char* name_of(std::uint32_t id) {
  switch (id) {
    case V4L2_CID_EXPOSURE_AUTO: return "manual exposure";
    case V4L2_CID_EXPOSURE_AUTO_PRIORITY: return "a fixed frame rate";
    case V4L2_CID_EXPOSURE_ABSOLUTE: return "exposure";
    case V4L2_CID_AUTOGAIN: return "manual gain";
    default: return "gain";
  }
}

// Sets the values in their order, and leaves out those that the device refuses: they would be refused each time.
void leave_out_refused(V4l2Port& port, V4l2Settings& settings, V4l2ControlPlan& plan) {
  int kept = 0;
  for (int i = 0; i < settings.control_count; ++i) {
    const V4l2Control control = settings.controls[static_cast<std::size_t>(i)];
    v4l2_control set{control.id, control.value};
    if (const int error = port.control(VIDIOC_S_CTRL, &set); error != 0)
      plan.notes.push_back(std::string(name_of(control.id)) + " cannot be set: " + std::strerror(error));
    else
      settings.controls[static_cast<std::size_t>(kept++)] = control;
  }
  settings.control_count = kept;
}

}  // namespace

V4l2ControlPlan plan_controls(V4l2Port& port, std::optional<std::int64_t> exposure_us, std::optional<double> gain,
                              V4l2Settings& settings) {
  V4l2ControlPlan plan;
  plan_exposure(port, exposure_us, settings, plan);
  plan_gain(port, gain, settings, plan);
  leave_out_refused(port, settings, plan);
  return plan;
}

}  // namespace srd
