// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "drivers/camera/frame_sequence.hpp"

namespace srd {
namespace {

constexpr std::int64_t kPeriod = 20'000'000;

TEST(FrameSequence, KeepsTheDriversNumbersAndGaps) {
  FrameSequence sequence(kPeriod);
  EXPECT_EQ(sequence.next(5, 0), 5u);
  EXPECT_EQ(sequence.next(6, kPeriod), 6u);
  EXPECT_EQ(sequence.next(9, 4 * kPeriod), 9u);
}

TEST(FrameSequence, GoesOnPast32Bits) {
  FrameSequence sequence(kPeriod);
  EXPECT_EQ(sequence.next(0xffff'fffe, 0), 0xffff'fffeu);
  EXPECT_EQ(sequence.next(0xffff'ffff, 1), 0xffff'ffffu);
  EXPECT_EQ(sequence.next(0, 2), 0x1'0000'0000u);
  EXPECT_EQ(sequence.next(3, 3), 0x1'0000'0003u);
  // A second time round, in steps of a quarter.
  for (int i = 1; i <= 8; ++i)
    EXPECT_EQ(sequence.next(3 + static_cast<std::uint32_t>(i) * 0x4000'0000U, 3),
              0x1'0000'0003u + static_cast<std::uint64_t>(i) * 0x4000'0000u);
}

TEST(FrameSequence, AfterAReconnectCountsTheTimeThatPassed) {
  for (const std::uint32_t again : {0u, 11u, 1000u}) {
    FrameSequence sequence(kPeriod);
    EXPECT_EQ(sequence.next(10, 0), 10u);
    sequence.restart();
    EXPECT_EQ(sequence.next(again, 5 * kPeriod + kPeriod / 3), 15u) << again;
    EXPECT_EQ(sequence.next(again + 1, 6 * kPeriod), 16u) << again;
  }
}

TEST(FrameSequence, NeverRepeatsANumber) {
  FrameSequence sequence(kPeriod);
  EXPECT_EQ(sequence.next(10, 0), 10u);
  sequence.restart();
  EXPECT_EQ(sequence.next(10, 1), 11u);               // back at once
  EXPECT_EQ(sequence.next(10, 2), 12u);               // a driver that does not count
  EXPECT_EQ(sequence.next(0, 2 + 3 * kPeriod), 15u);  // one that starts again by itself
  EXPECT_EQ(sequence.next(1, 1), 16u);
  sequence.restart();
  EXPECT_EQ(sequence.next(7, -100 * kPeriod), 17u);  // a clock that fell back
}

TEST(FrameSequence, AFrameWithoutANumberIsTheNextOne) {
  FrameSequence sequence(kPeriod);
  EXPECT_EQ(sequence.next(10, 0), 10u);
  EXPECT_EQ(sequence.next_unnumbered(kPeriod), 11u);
  EXPECT_EQ(sequence.next(12, 2 * kPeriod), 12u) << "it had one";
  EXPECT_EQ(sequence.next_unnumbered(3 * kPeriod), 13u);
  EXPECT_EQ(sequence.next(13, 4 * kPeriod), 14u) << "it had none";
}

TEST(FrameSequence, WithoutAPeriodAReconnectIsOneStep) {
  FrameSequence sequence(0);
  EXPECT_EQ(sequence.next(10, 0), 10u);
  sequence.restart();
  EXPECT_EQ(sequence.next(0, 1'000'000'000'000), 11u);
}

}  // namespace
}  // namespace srd
