// SPDX-License-Identifier: Apache-2.0
#include "dsp/core/spsc_ring.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace srd {
namespace {

TEST(SpscRing, HoldsItsCapacityAndCountsWhatDoesNotFit) {
  SpscRing<int> ring(3);
  EXPECT_EQ(ring.front(), nullptr);
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ring.try_push(10 * round + i));
    EXPECT_FALSE(ring.try_push(99));
    EXPECT_EQ(ring.back(), nullptr);
    for (int i = 0; i < 3; ++i) {
      ASSERT_NE(ring.front(), nullptr);
      EXPECT_EQ(*ring.front(), 10 * round + i);
      ring.pop();
    }
    EXPECT_TRUE(ring.empty());
  }
  EXPECT_EQ(ring.overflow(), 5u);
}

TEST(SpscRing, PassesEverythingInOrderBetweenThreads) {
  struct Item {
    std::uint64_t number = 0, twice = 0;
  };
  SpscRing<Item> ring(7);
  constexpr std::uint64_t kItems = 200000;
  std::thread putting([&] {
    for (std::uint64_t i = 0; i < kItems;)
      if (Item* slot = ring.back(); slot != nullptr) {
        *slot = {i, 2 * i};
        ring.push();
        ++i;
      } else {
        std::this_thread::yield();
      }
  });
  bool in_order = true;
  for (std::uint64_t i = 0; i < kItems;)
    if (const Item* item = ring.front(); item != nullptr) {
      in_order = in_order && item->number == i && item->twice == 2 * i;
      ring.pop();
      ++i;
    } else {
      std::this_thread::yield();
    }
  putting.join();
  EXPECT_TRUE(in_order);
  EXPECT_TRUE(ring.empty());
}

}  // namespace
}  // namespace srd
