// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_stream.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/camera/v4l2/v4l2_apply.hpp"

namespace srd {

namespace {

// A v4l2_buffer with room for the planes that multi-planar devices want filled in.
struct BufferCall {
  v4l2_buffer buffer;
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes;

  BufferCall(std::uint32_t type, bool multi_planar, int n_planes, std::uint32_t index) noexcept {
    std::memset(&buffer, 0, sizeof buffer);
    std::memset(planes.data(), 0, sizeof planes);
    buffer.type = type;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (multi_planar) {
      buffer.m.planes = planes.data();
      buffer.length = static_cast<std::uint32_t>(n_planes);
    }
  }
  BufferCall(const BufferCall&) = delete;
  BufferCall& operator=(const BufferCall&) = delete;
};

std::int64_t ns_of(const v4l2_buffer& buffer) {
  return static_cast<std::int64_t>(buffer.timestamp.tv_sec) * 1'000'000'000 +
         static_cast<std::int64_t>(buffer.timestamp.tv_usec) * 1000;
}

}  // namespace

V4l2Failure V4l2Stream::start(const V4l2Settings& settings, int least_stride) noexcept {
  const V4l2Failure failure = set_up(settings, least_stride);
  if (failure.any()) stop();
  return failure;
}

V4l2Failure V4l2Stream::set_up(const V4l2Settings& settings, int least_stride) noexcept {
  {
    const std::lock_guard lock(mutex_);
    open_ = true;
  }
  V4l2Layout layout;
  if (const V4l2Failure failure = apply_settings(port_, settings, layout); failure.any()) return failure;
  type_ = settings.buffer_type();
  multi_planar_ = settings.multi_planar;
  planes_ = std::clamp(layout.planes, 1, VIDEO_MAX_PLANES);
  stride_ = std::max(layout.stride_bytes, least_stride);
  // The last row needs no padding. What a compressed frame takes, its decoder knows.
  image_bytes_ = settings.compressed ? 1 : static_cast<std::int64_t>(stride_) * (settings.height - 1) + least_stride;

  v4l2_requestbuffers request;
  std::memset(&request, 0, sizeof request);
  request.count = static_cast<std::uint32_t>(settings.buffers);
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
#ifdef V4L2_MEMORY_FLAG_NON_COHERENT
  // Cached memory where the driver can: reading uncached pixels costs more than finding the corners in them.
  request.flags = V4L2_MEMORY_FLAG_NON_COHERENT;
#endif
  if (const int error = port_.control(VIDIOC_REQBUFS, &request); error != 0) return {V4l2Step::kBuffers, error};
  if (request.count < 2) return {V4l2Step::kBuffers, ENOMEM};
  // Some drivers give more than is asked.
  count_ = static_cast<int>(std::min<std::uint32_t>(request.count, FramePool::kMaxBuffers));

  for (int i = 0; i < count_; ++i) {
    Slot& slot = slots_[static_cast<std::size_t>(i)];
    BufferCall call(type_, multi_planar_, planes_, static_cast<std::uint32_t>(i));
    if (const int error = port_.control(VIDIOC_QUERYBUF, &call.buffer); error != 0) return {V4l2Step::kMap, error};
    const std::uint32_t length = multi_planar_ ? call.planes[0].length : call.buffer.length;
    const std::uint32_t at = multi_planar_ ? call.planes[0].m.mem_offset : call.buffer.m.offset;
    if (static_cast<std::int64_t>(length) < image_bytes_) return {V4l2Step::kBuffers, 0};
    slot.region = port_.map(length, at);
    if (!slot.region.valid()) return {V4l2Step::kMap, errno};
    slot.offset = 0;
    read_flags(call.buffer.flags);
  }
  for (int i = 0; i < count_; ++i) {
    const std::lock_guard lock(mutex_);
    if (const int error = queue(static_cast<std::uint32_t>(i)); error != 0) return {V4l2Step::kQueue, error};
  }
  int type = static_cast<int>(type_);
  if (const int error = port_.control(VIDIOC_STREAMON, &type); error != 0) return {V4l2Step::kStreamOn, error};
  return {};
}

void V4l2Stream::stop() noexcept {
  const std::lock_guard lock(mutex_);
  if (!open_) return;
  if (count_ > 0) {
    int type = static_cast<int>(type_);
    static_cast<void>(port_.control(VIDIOC_STREAMOFF, &type));
  }
  for (Slot& slot : slots_) {
    slot.region.reset();
    slot.holder = Holder::kNobody;
  }
  if (count_ > 0) {
    v4l2_requestbuffers none;
    std::memset(&none, 0, sizeof none);
    none.type = type_;
    none.memory = V4L2_MEMORY_MMAP;
    static_cast<void>(port_.control(VIDIOC_REQBUFS, &none));
  }
  count_ = 0;
  open_ = false;
  port_.close();
}

V4l2Stream::Take V4l2Stream::take(V4l2Taken& taken) noexcept {
  BufferCall call(type_, multi_planar_, planes_, 0);
  if (const int error = port_.control(VIDIOC_DQBUF, &call.buffer); error != 0)
    return error == EAGAIN ? Take::kNothing : Take::kGone;
  if (call.buffer.index >= static_cast<std::uint32_t>(count_)) return Take::kGone;
  read_flags(call.buffer.flags);
  taken.buffer = call.buffer.index;
  taken.sequence = call.buffer.sequence;
  taken.stamp_ns = ns_of(call.buffer);
  Slot& slot = slots_[taken.buffer];
  const std::uint32_t used = multi_planar_ ? call.planes[0].bytesused : call.buffer.bytesused;
  slot.offset = multi_planar_ ? call.planes[0].data_offset : 0;
  const std::int64_t end = static_cast<std::int64_t>(slot.offset) + image_bytes_;
  taken.damaged = (call.buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || static_cast<std::int64_t>(used) < end ||
                  static_cast<std::int64_t>(slot.region.size()) < std::max<std::int64_t>(end, used);
  taken.bytes = used > slot.offset ? used - slot.offset : 0;
  const std::lock_guard lock(mutex_);
  slot.holder = Holder::kCaller;
  return Take::kTaken;
}

void V4l2Stream::give_back(std::uint32_t buffer) noexcept {
  const std::lock_guard lock(mutex_);
  if (!open_ || buffer >= static_cast<std::uint32_t>(count_) || slots_[buffer].holder != Holder::kCaller) return;
  if (queue(buffer) != 0) {
    slots_[buffer].holder = Holder::kNobody;
    count_one(faults_.requeue_failures);
  }
}

void V4l2Stream::requeue_idle() noexcept {
  const std::lock_guard lock(mutex_);
  for (int i = 0; i < count_; ++i)
    if (slots_[static_cast<std::size_t>(i)].holder == Holder::kNobody) static_cast<void>(queue(static_cast<std::uint32_t>(i)));
}

int V4l2Stream::queue(std::uint32_t buffer) noexcept {
  BufferCall call(type_, multi_planar_, planes_, buffer);
  if (multi_planar_)
    for (int plane = 0; plane < planes_; ++plane) call.planes[static_cast<std::size_t>(plane)].bytesused = 0;
  const int error = port_.control(VIDIOC_QBUF, &call.buffer);
  if (error == 0) slots_[buffer].holder = Holder::kDriver;
  return error;
}

void V4l2Stream::read_flags(std::uint32_t flags) noexcept {
  clock_ =
      (flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC ? ClockId::kMonotonic : ClockId::kUnknown;
  mark_ = (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE ? StampMark::kExposureStart
                                                                                  : StampMark::kFrameEnd;
}

int V4l2Stream::borrowed() const noexcept { return count(Holder::kCaller); }
int V4l2Stream::queued() const noexcept { return count(Holder::kDriver); }

int V4l2Stream::count(Holder holder) const noexcept {
  const std::lock_guard lock(mutex_);
  int n = 0;
  for (int i = 0; i < count_; ++i) n += slots_[static_cast<std::size_t>(i)].holder == holder ? 1 : 0;
  return n;
}

}  // namespace srd
