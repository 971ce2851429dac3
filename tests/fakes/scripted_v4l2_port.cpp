// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/scripted_v4l2_port.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/camera/v4l2/v4l2_format.hpp"

namespace srd::fakes {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::uint32_t kOffsetStep = 1 << 24;  // between the buffers' offsets

// Bytes of a row; 0 for what has no rows.
int stride_of(const ScriptedFormat& scripted) {
  const V4l2PixelFormat* format = v4l2_format_of(scripted.code);
  if (format == nullptr) return 3 * scripted.width + scripted.padding;
  return format->compressed() ? 0 : row_bytes(format->layout, scripted.width) + scripted.padding;
}

// One sample into its place in a row whose other samples are written too.
void put(const V4l2PixelFormat& format, std::uint8_t* row, int u, std::uint8_t value) {
  switch (format.layout) {
    case GrayLayout::kLittleEndian:
      row[2 * u] = static_cast<std::uint8_t>(value << (format.bits - 8));
      row[2 * u + 1] = static_cast<std::uint8_t>(value >> (16 - format.bits));
      break;
    case GrayLayout::kPackedTen:
      row[u + u / 4] = value;
      row[5 * (u / 4) + 4] = 0;
      break;
    case GrayLayout::kEvenBytes:
      row[2 * u] = value;
      row[2 * u + 1] = 0x80;
      break;
    default: row[u] = value; break;
  }
}

void copy_text(std::uint8_t* to, std::size_t room, const char* text) {
  std::memcpy(to, text, std::min(room - 1, std::strlen(text)));
}

}  // namespace

int ScriptedV4l2Port::open(const char* path) noexcept {
  close();
  if (path != device_.path) return ENOENT;
  if (!present()) return ENODEV;
  if (device_.open_error != 0) return device_.open_error;
  open_ = true;
  broken_ = still_ = false;
  format_ = &device_.formats.front();
  ++device_.opened;
  return 0;
}

void ScriptedV4l2Port::close() noexcept {
  open_ = streaming_ = false;
  buffers_.clear();
  done_.clear();
}

std::uint32_t ScriptedV4l2Port::image_bytes() const {
  const int stride = stride_of(*format_);
  return static_cast<std::uint32_t>((stride > 0 ? stride : 2 * format_->width + 1024) * format_->height);
}

int ScriptedV4l2Port::control(unsigned long request, void* argument) noexcept {
  if (!open_) return EBADF;
  if (broken_ || !present()) return ENODEV;
  if (const auto error = device_.errors.find(request); error != device_.errors.end()) return error->second;
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& answer = *static_cast<v4l2_capability*>(argument);
      copy_text(answer.card, sizeof answer.card, "Scripted camera");
      copy_text(answer.driver, sizeof answer.driver, "scripted");
      copy_text(answer.bus_info, sizeof answer.bus_info, "test:1");
      answer.device_caps = device_.capabilities;
      answer.capabilities = device_.capabilities | V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_OUTPUT;
      return 0;
    }
    case VIDIOC_TRY_FMT: return answer_format(*static_cast<v4l2_format*>(argument), false);
    case VIDIOC_S_FMT: return answer_format(*static_cast<v4l2_format*>(argument), true);
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& parm = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      if (request == VIDIOC_S_PARM && device_.sets_rate) {
        const double wanted = static_cast<double>(parm.timeperframe.denominator) / parm.timeperframe.numerator;
        rate_hz_ = *std::min_element(format_->rates_hz.begin(), format_->rates_hz.end(),
                                     [&](int a, int b) { return std::abs(a - wanted) < std::abs(b - wanted); });
      }
      parm.capability = device_.sets_rate ? V4L2_CAP_TIMEPERFRAME : 0;
      parm.timeperframe = {1, static_cast<std::uint32_t>(rate_hz_)};
      return 0;
    }
    case VIDIOC_QUERYCTRL: {
      auto& answer = *static_cast<v4l2_queryctrl*>(argument);
      const auto found = device_.controls.find(answer.id);
      if (found == device_.controls.end()) return EINVAL;
      answer.minimum = found->second.low;
      answer.maximum = found->second.high;
      answer.step = found->second.step;
      answer.flags = found->second.flags;
      answer.default_value = found->second.standard;
      return 0;
    }
    case VIDIOC_QUERYMENU: {
      const auto& menu = *static_cast<v4l2_querymenu*>(argument);
      return device_.controls[menu.id].menu.count(static_cast<std::int32_t>(menu.index)) != 0 ? 0 : EINVAL;
    }
    case VIDIOC_G_CTRL:
    case VIDIOC_S_CTRL: {
      auto& value = *static_cast<v4l2_control*>(argument);
      const auto found = device_.controls.find(value.id);
      if (found == device_.controls.end()) return EINVAL;
      if (request == VIDIOC_S_CTRL && (found->second.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return EACCES;
      if (request == VIDIOC_S_CTRL && !found->second.stubborn) found->second.value = value.value;
      value.value = found->second.value;
      return 0;
    }
    case VIDIOC_G_EXT_CTRLS: {
      v4l2_ext_control& value = *static_cast<v4l2_ext_controls*>(argument)->controls;
      if (value.id != V4L2_CID_PIXEL_RATE || device_.pixel_rate == 0) return EINVAL;
      value.value64 = device_.pixel_rate;
      return 0;
    }
    case VIDIOC_G_SELECTION: {
      auto& selection = *static_cast<v4l2_selection*>(argument);
      if (selection.target != V4L2_SEL_TGT_CROP || device_.crop_width == 0) return EINVAL;
      selection.r.width = static_cast<std::uint32_t>(device_.crop_width);
      return 0;
    }
    case VIDIOC_ENUM_FMT:
    case VIDIOC_ENUM_FRAMESIZES:
    case VIDIOC_ENUM_FRAMEINTERVALS: return answer_enumeration(request, argument);
    case VIDIOC_REQBUFS:
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
    case VIDIOC_DQBUF: return answer_buffers(request, argument);
    case VIDIOC_STREAMON:
      streaming_ = true;
      sequence_ = device_.first_sequence;
      next_frame_ns_ = device_.now_ns + kSecond / rate_hz_;
      return 0;
    case VIDIOC_STREAMOFF: streaming_ = false; return 0;
    default: return ENOTTY;
  }
}

int ScriptedV4l2Port::answer_format(v4l2_format& format, bool keep) {
  const bool planes = multi_planar();
  if (format.type != (planes ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE)) return EINVAL;
  const std::uint32_t code = planes ? format.fmt.pix_mp.pixelformat : format.fmt.pix.pixelformat;
  const std::uint32_t width = planes ? format.fmt.pix_mp.width : format.fmt.pix.width;
  // As drivers do: the format that is wanted, else the first; of it the size that is wanted, else its first.
  const ScriptedFormat* best = nullptr;
  for (const ScriptedFormat& offered : device_.formats)
    if (offered.code == code && (best == nullptr || static_cast<std::uint32_t>(offered.width) == width)) best = &offered;
  if (best == nullptr) best = &device_.formats.front();
  const ScriptedFormat* const before = format_;
  format_ = best;
  const std::uint32_t bytes = image_bytes();
  const auto stride = static_cast<std::uint32_t>(stride_of(*format_));
  if (planes) {
    v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    pix.pixelformat = best->code;
    pix.width = static_cast<std::uint32_t>(best->width);
    pix.height = static_cast<std::uint32_t>(best->height);
    pix.field = device_.field;
    pix.num_planes = 1;
    pix.plane_fmt[0].bytesperline = stride;
    pix.plane_fmt[0].sizeimage = bytes;
  } else {
    v4l2_pix_format& pix = format.fmt.pix;
    pix.pixelformat = best->code;
    pix.width = static_cast<std::uint32_t>(best->width);
    pix.height = static_cast<std::uint32_t>(best->height);
    pix.field = device_.field;
    pix.bytesperline = stride;
    pix.sizeimage = bytes;
  }
  if (!keep) format_ = before;
  return 0;
}

int ScriptedV4l2Port::answer_enumeration(unsigned long request, void* argument) {
  std::vector<std::uint32_t> codes;
  for (const ScriptedFormat& format : device_.formats)
    if (std::find(codes.begin(), codes.end(), format.code) == codes.end()) codes.push_back(format.code);
  if (request == VIDIOC_ENUM_FMT) {
    auto& answer = *static_cast<v4l2_fmtdesc*>(argument);
    if (answer.index >= codes.size()) return EINVAL;
    answer.pixelformat = codes[answer.index];
    return 0;
  }
  if (request == VIDIOC_ENUM_FRAMESIZES) {
    auto& answer = *static_cast<v4l2_frmsizeenum*>(argument);
    std::uint32_t at = 0;
    for (const ScriptedFormat& format : device_.formats)
      if (format.code == answer.pixel_format && at++ == answer.index) {
        answer.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        answer.discrete = {static_cast<std::uint32_t>(format.width), static_cast<std::uint32_t>(format.height)};
        return 0;
      }
    return EINVAL;
  }
  auto& answer = *static_cast<v4l2_frmivalenum*>(argument);
  for (const ScriptedFormat& format : device_.formats)
    if (format.code == answer.pixel_format && static_cast<std::uint32_t>(format.width) == answer.width &&
        answer.index < format.rates_hz.size()) {
      answer.type = V4L2_FRMIVAL_TYPE_DISCRETE;
      answer.discrete = {1, static_cast<std::uint32_t>(format.rates_hz[answer.index])};
      return 0;
    }
  return EINVAL;
}

void ScriptedV4l2Port::describe(v4l2_buffer& buffer, std::uint32_t index) const {
  buffer.index = index;
  buffer.flags |= device_.buffer_flags;
  if (multi_planar()) {
    buffer.m.planes[0].length = image_bytes();
    buffer.m.planes[0].m.mem_offset = index * kOffsetStep;
    buffer.m.planes[0].bytesused = buffers_[index].bytes_used;
  } else {
    buffer.length = image_bytes();
    buffer.m.offset = index * kOffsetStep;
    buffer.bytesused = buffers_[index].bytes_used;
  }
}

int ScriptedV4l2Port::answer_buffers(unsigned long request, void* argument) {
  if (request == VIDIOC_REQBUFS) {
    auto& answer = *static_cast<v4l2_requestbuffers*>(argument);
    answer.count = std::min(answer.count, static_cast<std::uint32_t>(device_.most_buffers));
    buffers_.assign(answer.count, {});
    done_.clear();
    done_.reserve(answer.count);  // the driver's allocations are counted
    return 0;
  }
  auto& buffer = *static_cast<v4l2_buffer*>(argument);
  if (request == VIDIOC_DQBUF) {
    if (done_.empty()) return EAGAIN;
    Buffer& taken = buffers_[done_.front()];
    buffer.sequence = taken.filled.sequence;
    buffer.timestamp = taken.filled.timestamp;
    buffer.flags = taken.filled.flags;
    describe(buffer, done_.front());
    done_.erase(done_.begin());
    taken.queued = false;
    return 0;
  }
  if (buffer.index >= buffers_.size()) return EINVAL;
  if (request == VIDIOC_QUERYBUF) {
    describe(buffer, buffer.index);
    return 0;
  }
  if (buffers_[buffer.index].queued) return EINVAL;
  buffers_[buffer.index].queued = true;
  buffers_[buffer.index].done = false;
  return 0;
}

MappedRegion ScriptedV4l2Port::map(std::size_t length, std::int64_t offset) noexcept {
  MappedRegion region = MappedRegion::anonymous(length);
  buffers_[static_cast<std::size_t>(offset / kOffsetStep)].memory = region.data();
  return region;
}

void ScriptedV4l2Port::fill(std::uint64_t frame, std::int64_t time_ns) {
  const std::uint32_t number = sequence_++;
  for (std::uint32_t i = 0; i < buffers_.size(); ++i) {
    Buffer& buffer = buffers_[i];
    if (!buffer.queued || buffer.done) continue;
    buffer.done = true;
    done_.push_back(i);
    buffer.filled.sequence = number;
    buffer.filled.flags = device_.damaged.count(frame) != 0 ? V4L2_BUF_FLAG_ERROR : 0;
    buffer.bytes_used = device_.truncated.count(frame) != 0 ? image_bytes() / 2 : image_bytes();
    const std::int64_t stamp_ns = !device_.stamps ? 0 : device_.stamp ? device_.stamp(frame, time_ns) : time_ns;
    buffer.filled.timestamp.tv_sec = static_cast<time_t>(stamp_ns / kSecond);
    buffer.filled.timestamp.tv_usec = static_cast<suseconds_t>(stamp_ns % kSecond / 1000);
    const V4l2PixelFormat* format = v4l2_format_of(format_->code);
    if (format == nullptr) return;
    if (format->compressed()) {
      const std::vector<std::uint8_t>& jpeg = device_.jpegs[frame % device_.jpegs.size()];
      std::memcpy(buffer.memory, jpeg.data(), jpeg.size());
      if (device_.truncated.count(frame) == 0) buffer.bytes_used = static_cast<std::uint32_t>(jpeg.size());
      return;
    }
    const int stride = stride_of(*format_), reduction = format->reduction();
    for (int v = 0; v < format_->height; ++v)
      for (int u = 0; u < format_->width; ++u) {
        const int x = u / reduction, y = v / reduction;
        const bool green = (u + v) % 2 == (format->mosaic == Mosaic::kGreenFirst ? 0 : 1);
        std::uint8_t value = device_.scene ? device_.scene(frame, x, y) : ScriptedV4l2Device::pixel(frame, x, y);
        if (reduction > 1 && !green) value = 0x11;
        put(*format, buffer.memory + static_cast<std::ptrdiff_t>(v) * stride, u, value);
      }
    return;
  }
}

V4l2Port::Ready ScriptedV4l2Port::wait(std::chrono::nanoseconds timeout) noexcept {
  const std::int64_t deadline = device_.now_ns + timeout.count();
  for (;;) {
    if (device_.now_ns < device_.fails_until_ns) broken_ = true;
    if (!open_ || broken_ || !streaming_) return Ready::kError;
    if (!done_.empty()) return Ready::kFrame;
    if (still_ || next_frame_ns_ > deadline) {
      device_.now_ns = deadline;
      return Ready::kTimeout;
    }
    device_.now_ns = std::max(device_.now_ns, next_frame_ns_);
    if (const auto gone = device_.gone.find(device_.frames); gone != device_.gone.end()) {
      broken_ = true;
      back_ns_ = device_.now_ns + gone->second;
      device_.gone.erase(gone);
      return Ready::kError;
    }
    if (device_.stands_still.erase(device_.frames) != 0) {
      still_ = true;
      continue;
    }
    fill(device_.frames++, next_frame_ns_);
    next_frame_ns_ += kSecond / rate_hz_;
  }
}

}  // namespace srd::fakes
