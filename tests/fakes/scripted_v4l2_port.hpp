// SPDX-License-Identifier: Apache-2.0
// A video device made of numbers, behind the port of the V4L2 driver: what it offers, what it does wrong and when.
// Its clock moves only while the driver waits.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_port.hpp"

namespace srd::fakes {

struct ScriptedFormat {
  std::uint32_t code = V4L2_PIX_FMT_GREY;
  int width = 64, height = 48;
  std::vector<int> rates_hz{30, 60};
  int padding = 0;  // bytes at the end of each row
};

struct ScriptedControl {
  std::int32_t low = 0, high = 100, step = 1, value = 0;
  std::set<std::int32_t> menu{};  // items, when it is one
  std::uint32_t flags = 0;
  std::int32_t standard = 0;  // the driver's default
  bool stubborn = false;      // takes a value and keeps its own
};

// One device, which ports open. Test side: set before the driver starts, or between its calls.
struct ScriptedV4l2Device {
  std::string path = "/dev/video9";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<ScriptedFormat> formats{{}};
  std::map<std::uint32_t, ScriptedControl> controls;
  std::int64_t pixel_rate = 0;  // V4L2_CID_PIXEL_RATE, of 64 bits; 0: it has none
  int crop_width = 0;           // of the sensor, px; 0: it tells none
  std::uint32_t field = V4L2_FIELD_NONE;
  std::uint32_t buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  bool sets_rate = true;
  int most_buffers = 32;
  std::map<unsigned long, int> errors;  // errno that a request answers with
  int open_error = 0;
  std::uint32_t first_sequence = 0;  // after each start of the stream

  // Faults of the stream, by the count of frames since the device was made (the first one is 0).
  std::set<std::uint64_t> damaged, truncated;
  std::map<std::uint64_t, std::int64_t> gone;  // before that frame the device goes away, for so many ns
  std::set<std::uint64_t> stands_still;        // gives nothing from that frame on, until it is opened again
  std::int64_t fails_until_ns = 0;             // till then it opens and starts, and fails at once
  bool stamps = true;
  // What the driver writes for a frame that is done at that time; none: the time itself.
  std::function<std::int64_t(std::uint64_t frame, std::int64_t time_ns)> stamp;
  std::vector<std::vector<std::uint8_t>> jpegs;  // its frames in a compressed format, again from the first one
  // Grey level of a pixel in what it films; none: pixel(). A mosaic's green pixels show it, the others nothing.
  std::function<std::uint8_t(std::uint64_t frame, int u, int v)> scene;

  // State.
  std::int64_t now_ns = 5'000'000'000;
  std::uint64_t frames = 0;  // made since the beginning
  int opened = 0;

  [[nodiscard]] static std::uint8_t pixel(std::uint64_t frame, int u, int v) {
    return static_cast<std::uint8_t>(3 * u + 5 * v + 7 * static_cast<int>(frame % 29));
  }
};

class ScriptedV4l2Port final : public V4l2Port {
 public:
  explicit ScriptedV4l2Port(ScriptedV4l2Device& device) : device_(device) {}

  int open(const char* path) noexcept override;
  void close() noexcept override;
  int control(unsigned long request, void* argument) noexcept override;
  MappedRegion map(std::size_t length, std::int64_t offset) noexcept override;
  Ready wait(std::chrono::nanoseconds timeout) noexcept override;
  std::int64_t now_ns() noexcept override { return device_.now_ns; }
  void pause(std::chrono::nanoseconds time) noexcept override { device_.now_ns += time.count(); }

 private:
  struct Buffer {
    std::uint8_t* memory = nullptr;
    bool queued = false, done = false;
    v4l2_buffer filled{};
    std::uint32_t bytes_used = 0;
  };
  [[nodiscard]] bool present() const { return device_.now_ns >= back_ns_; }
  [[nodiscard]] bool multi_planar() const { return (device_.capabilities & V4L2_CAP_VIDEO_CAPTURE) == 0; }
  [[nodiscard]] std::uint32_t image_bytes() const;
  int answer_format(v4l2_format& format, bool keep);
  int answer_enumeration(unsigned long request, void* argument);
  int answer_buffers(unsigned long request, void* argument);
  void describe(v4l2_buffer& buffer, std::uint32_t index) const;
  void fill(std::uint64_t frame, std::int64_t time_ns);

  ScriptedV4l2Device& device_;
  bool open_ = false, streaming_ = false, broken_ = false, still_ = false;
  std::int64_t back_ns_ = 0;                // when a device that went away is there again
  const ScriptedFormat* format_ = nullptr;  // of the device's list
  int rate_hz_ = 30;
  std::vector<Buffer> buffers_;
  std::vector<std::uint32_t> done_;
  std::uint32_t sequence_ = 0;
  std::int64_t next_frame_ns_ = 0;
};

}  // namespace srd::fakes
