// SPDX-License-Identifier: Apache-2.0
// When a frame's light fell: from what the driver's time stamp marks to exposure, in integers. Pure; any thread.
//
// Model, e the exposure and r the time from the first row's readout to the last one's:
//   global shutter   all rows expose [t0, t0 + e); they are read out in [t0 + e, t0 + e + r)
//   rolling shutter  the row at fraction f of the height exposes [t0 + f r, t0 + f r + e)
//   stamps           exposure start: t0; frame start: t0 + e; frame end: t0 + e + r
#pragma once

#include <cstdint>
#include <string_view>

namespace srd {

enum class Shutter : std::uint8_t { kGlobal, kRolling };

// What a driver's time stamp is the time of.
enum class StampMark : std::uint8_t { kExposureStart, kFrameStart, kFrameEnd };

[[nodiscard]] constexpr std::string_view to_string(Shutter shutter) {
  return shutter == Shutter::kRolling ? "rolling" : "global";
}
[[nodiscard]] constexpr std::string_view to_string(StampMark mark) {
  switch (mark) {
    case StampMark::kExposureStart: return "exposure-start";
    case StampMark::kFrameStart: return "frame-start";
    case StampMark::kFrameEnd: return "frame-end";
  }
  return "frame-end";
}

// Half open, ns of the stamp's clock.
struct TimeWindow {
  std::int64_t begin_ns = 0, end_ns = 0;
  [[nodiscard]] constexpr bool empty() const { return end_ns <= begin_ns; }
  [[nodiscard]] constexpr std::int64_t length_ns() const { return empty() ? 0 : end_ns - begin_ns; }
  [[nodiscard]] constexpr bool operator==(const TimeWindow&) const = default;
};

struct FrameTiming {
  static constexpr std::int32_t kWholeHeight = 1 << 16;

  Shutter shutter = Shutter::kGlobal;
  StampMark mark = StampMark::kFrameEnd;
  std::int64_t readout_ns = 0;   // first row to last row, 0 to 1 s
  std::int64_t exposure_ns = 0;  // 0: unknown; times are then those of the readout
  // Row whose middle is the frame's time, as a fraction of the height in 2^-16: 0 the first row, 2^16 the last.
  // Rolling shutters only. readout_ns < 2^30 and this <= 2^16: the product has 17 bits to spare in 64.
  std::int32_t row_fraction = kWholeHeight / 2;

  // t0: the (first row's) exposure begins.
  [[nodiscard]] constexpr std::int64_t exposure_start_ns(std::int64_t stamp_ns) const {
    switch (mark) {
      case StampMark::kExposureStart: return stamp_ns;
      case StampMark::kFrameStart: return stamp_ns - exposure_ns;
      case StampMark::kFrameEnd: return stamp_ns - exposure_ns - readout_ns;
    }
    return stamp_ns;
  }
  // From t0 to the middle of the light, without a strobe.
  [[nodiscard]] constexpr std::int64_t middle_offset_ns() const {
    const std::int64_t row = shutter == Shutter::kRolling ? (readout_ns * row_fraction + kWholeHeight / 2) / kWholeHeight : 0;
    return row + exposure_ns / 2;
  }
  // The frame's time, CameraFrame::time_ns.
  [[nodiscard]] constexpr std::int64_t middle_ns(std::int64_t stamp_ns) const {
    return exposure_start_ns(stamp_ns) + middle_offset_ns();
  }
  // t0 of a frame whose time is known.
  [[nodiscard]] constexpr std::int64_t exposure_start_of_middle_ns(std::int64_t middle) const {
    return middle - middle_offset_ns();
  }
  // Light in this window reaches every row alike; empty when a rolling shutter's rows never integrate together.
  [[nodiscard]] constexpr TimeWindow all_rows(std::int64_t exposure_start) const {
    const std::int64_t late = shutter == Shutter::kRolling ? readout_ns : 0;
    return {exposure_start + late, exposure_start + exposure_ns};
  }
  [[nodiscard]] constexpr TimeWindow all_rows_of_stamp(std::int64_t stamp_ns) const {
    return all_rows(exposure_start_ns(stamp_ns));
  }
};

// The row v (px) of an image of some height as FrameTiming takes it; rows outside count as the nearest one.
[[nodiscard]] constexpr std::int32_t row_fraction_of(double v, int height) {
  if (height < 2 || !(v > 0)) return 0;
  const double last = height - 1;
  return v >= last ? FrameTiming::kWholeHeight : static_cast<std::int32_t>(v / last * FrameTiming::kWholeHeight + 0.5);
}

}  // namespace srd
