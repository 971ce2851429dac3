// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_line_time.hpp"

#include <linux/videodev2.h>

#include <cstring>

namespace srd {

namespace {

// Of any width: 64-bit controls, as the pixel rate is one, are read by the extended call only.
std::optional<std::int64_t> control_value(V4l2Port& port, std::uint32_t id, bool wide) noexcept {
  if (!wide) {
    v4l2_control control{id, 0};
    if (port.control(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
    return control.value;
  }
  v4l2_ext_control control;
  v4l2_ext_controls controls;
  std::memset(&control, 0, sizeof control);
  std::memset(&controls, 0, sizeof controls);
  control.id = id;
  controls.which = V4L2_CTRL_WHICH_CUR_VAL;
  controls.count = 1;
  controls.controls = &control;
  if (port.control(VIDIOC_G_EXT_CTRLS, &controls) != 0) return std::nullopt;
  const std::int64_t value = control.value64;  // the struct is packed: no reference to a member
  return value;
}

}  // namespace

std::optional<double> v4l2_line_time_ns(V4l2Port& port, const V4l2Settings& settings) noexcept {
  const auto pixel_rate = control_value(port, V4L2_CID_PIXEL_RATE, true);
  const auto blanking = control_value(port, V4L2_CID_HBLANK, false);
  if (!pixel_rate || *pixel_rate <= 0 || !blanking) return std::nullopt;
  std::int64_t width = settings.width;
  v4l2_selection crop;
  std::memset(&crop, 0, sizeof crop);
  crop.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;  // the selection calls take the plain type for multi-planar devices too
  crop.target = V4L2_SEL_TGT_CROP;
  if (port.control(VIDIOC_G_SELECTION, &crop) == 0 && crop.r.width > 0) width = crop.r.width;
  const std::int64_t line = width + *blanking;  // pixels; blanking may be negative where rows are binned
  if (line <= 0) return std::nullopt;
  return 1e9 * static_cast<double>(line) / static_cast<double>(*pixel_rate);
}

}  // namespace srd
