// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_apply.hpp"

#include <cerrno>
#include <cstring>

namespace srd {

v4l2_format v4l2_format_request(const V4l2Settings& settings) noexcept {
  v4l2_format format;
  std::memset(&format, 0, sizeof format);
  format.type = settings.buffer_type();
  if (settings.multi_planar) {
    format.fmt.pix_mp.pixelformat = settings.code;
    format.fmt.pix_mp.width = static_cast<std::uint32_t>(settings.width);
    format.fmt.pix_mp.height = static_cast<std::uint32_t>(settings.height);
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
  } else {
    format.fmt.pix.pixelformat = settings.code;
    format.fmt.pix.width = static_cast<std::uint32_t>(settings.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(settings.height);
    format.fmt.pix.field = V4L2_FIELD_NONE;
  }
  return format;
}

V4l2Answer read_answer(const v4l2_format& format, bool multi_planar) noexcept {
  V4l2Answer answer;
  if (multi_planar) {
    const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    answer = {pix.pixelformat, static_cast<int>(pix.width), static_cast<int>(pix.height), pix.field, {}};
    answer.layout.stride_bytes = static_cast<int>(pix.plane_fmt[0].bytesperline);
    answer.layout.planes = pix.num_planes;
  } else {
    const v4l2_pix_format& pix = format.fmt.pix;
    answer = {pix.pixelformat, static_cast<int>(pix.width), static_cast<int>(pix.height), pix.field, {}};
    answer.layout.stride_bytes = static_cast<int>(pix.bytesperline);
  }
  return answer;
}

int take_detected_timings(V4l2Port& port) noexcept {
  v4l2_dv_timings found, set;
  std::memset(&found, 0, sizeof found);
  std::memset(&set, 0, sizeof set);
  if (port.control(VIDIOC_QUERY_DV_TIMINGS, &found) != 0) return 0;  // nothing plugged in, or it cannot tell
  if (port.control(VIDIOC_G_DV_TIMINGS, &set) == 0 && set.bt.width == found.bt.width && set.bt.height == found.bt.height &&
      set.bt.pixelclock == found.bt.pixelclock && set.bt.interlaced == found.bt.interlaced)
    return 0;
  return port.control(VIDIOC_S_DV_TIMINGS, &found);
}

V4l2Failure apply_settings(V4l2Port& port, const V4l2Settings& settings, V4l2Layout& layout) noexcept {
  if (settings.detect_timings)
    if (const int error = take_detected_timings(port); error != 0) return {V4l2Step::kTimings, error};

  v4l2_format format = v4l2_format_request(settings);
  if (const int error = port.control(VIDIOC_S_FMT, &format); error != 0) return {V4l2Step::kFormat, error};
  const V4l2Answer answer = read_answer(format, settings.multi_planar);
  if (answer.code != settings.code || answer.width != settings.width || answer.height != settings.height ||
      answer.field != V4L2_FIELD_NONE)
    return {V4l2Step::kFormat, 0, answer.code, answer.width, answer.height};
  layout = answer.layout;

  if (settings.set_interval && settings.period_ns() > 0) {
    v4l2_streamparm rate;
    std::memset(&rate, 0, sizeof rate);
    rate.type = settings.buffer_type();
    rate.parm.capture.timeperframe = settings.interval;
    if (const int error = port.control(VIDIOC_S_PARM, &rate); error != 0) return {V4l2Step::kInterval, error};
    const v4l2_fract got = rate.parm.capture.timeperframe;
    if (got.numerator == 0 || got.denominator == 0 ||
        !same_rate(static_cast<double>(got.denominator) / got.numerator,
                   static_cast<double>(settings.interval.denominator) / settings.interval.numerator))
      return {V4l2Step::kInterval, 0};
  }
  for (int i = 0; i < settings.control_count; ++i) {
    v4l2_control control{settings.controls[static_cast<std::size_t>(i)].id,
                         settings.controls[static_cast<std::size_t>(i)].value};
    if (const int error = port.control(VIDIOC_S_CTRL, &control); error != 0) return {V4l2Step::kControl, error};
  }
  return {};
}

}  // namespace srd
