// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/camera/frame_timing.hpp"

namespace srd {
namespace {

constexpr std::int64_t kStart = 1'000'000'000, kExposure = 2'000'000, kReadout = 9'000'000;
constexpr std::int32_t kRow = FrameTiming::kWholeHeight / 4;

// What the model says each mark's stamp is for a frame whose exposure begins at kStart.
constexpr std::int64_t stamp_of(StampMark mark) {
  return mark == StampMark::kExposureStart ? kStart
         : mark == StampMark::kFrameStart  ? kStart + kExposure
                                           : kStart + kExposure + kReadout;
}

constexpr StampMark kMarks[] = {StampMark::kExposureStart, StampMark::kFrameStart, StampMark::kFrameEnd};

TEST(FrameTiming, GivesOneFrameTheSameTimesWhateverIsStamped) {
  for (const StampMark mark : kMarks) {
    const FrameTiming global{Shutter::kGlobal, mark, kReadout, kExposure, kRow};
    EXPECT_EQ(global.exposure_start_ns(stamp_of(mark)), kStart);
    EXPECT_EQ(global.middle_ns(stamp_of(mark)), kStart + kExposure / 2);
    const FrameTiming rolling{Shutter::kRolling, mark, kReadout, kExposure, kRow};
    EXPECT_EQ(rolling.exposure_start_ns(stamp_of(mark)), kStart);
    EXPECT_EQ(rolling.middle_ns(stamp_of(mark)), kStart + kReadout / 4 + kExposure / 2);
  }
}

TEST(FrameTiming, TheMiddleLeadsBackToTheExposuresStart) {
  for (const Shutter shutter : {Shutter::kGlobal, Shutter::kRolling}) {
    const FrameTiming timing{shutter, StampMark::kFrameEnd, 7'777'777, 1'234'567, 12'345};
    const std::int64_t stamp = 123'456'789'012'345;
    EXPECT_EQ(timing.exposure_start_of_middle_ns(timing.middle_ns(stamp)), timing.exposure_start_ns(stamp));
  }
}

TEST(FrameTiming, EveryInstantOfTheWindowLiesInEveryRowsExposure) {
  for (const Shutter shutter : {Shutter::kGlobal, Shutter::kRolling})
    for (const std::int64_t exposure : {kReadout / 2, kReadout, kReadout + 1, 3 * kReadout}) {
      const FrameTiming timing{shutter, StampMark::kExposureStart, kReadout, exposure, kRow};
      const TimeWindow window = timing.all_rows_of_stamp(kStart);
      // The first and the last row bound all others.
      const std::int64_t last_row = kStart + (shutter == Shutter::kRolling ? kReadout : 0);
      EXPECT_EQ(window.begin_ns, last_row);
      EXPECT_EQ(window.end_ns, kStart + exposure);
      EXPECT_EQ(window.empty(), last_row >= kStart + exposure);
      EXPECT_EQ(window.length_ns(), std::max<std::int64_t>(0, kStart + exposure - last_row));
    }
}

TEST(FrameTiming, AnUnknownExposureLeavesTheReadout) {
  const FrameTiming timing{Shutter::kGlobal, StampMark::kFrameEnd, kReadout, 0, kRow};
  EXPECT_EQ(timing.middle_ns(kStart + kReadout), kStart);
  EXPECT_TRUE(timing.all_rows_of_stamp(kStart).empty());
}

TEST(FrameTiming, RowsBecomeFractionsOfTheHeight) {
  EXPECT_EQ(row_fraction_of(0, 1080), 0);
  EXPECT_EQ(row_fraction_of(539.5, 1080), FrameTiming::kWholeHeight / 2);
  EXPECT_EQ(row_fraction_of(1079, 1080), FrameTiming::kWholeHeight);
  EXPECT_EQ(row_fraction_of(-50, 1080), 0);
  EXPECT_EQ(row_fraction_of(5000, 1080), FrameTiming::kWholeHeight);
  EXPECT_EQ(row_fraction_of(0.0 / 1.0, 1), 0);
  // One row of a slow rolling shutter: no product leaves 64 bits, no row is off by more than the rounding.
  const FrameTiming timing{Shutter::kRolling, StampMark::kExposureStart, 999'999'999, 0, row_fraction_of(270, 1080)};
  EXPECT_NEAR(static_cast<double>(timing.middle_ns(0)), 999'999'999.0 * 270 / 1079, 999'999'999.0 / FrameTiming::kWholeHeight);
}

// Usable in constant expressions.
static_assert(FrameTiming{Shutter::kGlobal, StampMark::kFrameStart, 0, 100, 0}.middle_ns(1000) == 950);

}  // namespace
}  // namespace srd
