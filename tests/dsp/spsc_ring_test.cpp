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

// Where both threads share a core, each meeting of a full or an empty ring costs a turn of the scheduler, and on a busy machine
// that of others too: few of them in small rings, which meet them all the time; the many items go through a large one.
void expect_everything_in_order(std::size_t capacity, std::uint64_t items) {
  struct Item {
    std::uint64_t number = 0, twice = 0;
  };
  SpscRing<Item> ring(capacity);
  std::thread putting([&] {
    for (std::uint64_t i = 0; i < items;)
      if (Item* slot = ring.back(); slot != nullptr) {
        *slot = {i, 2 * i};
        ring.push();
        ++i;
      } else {
        std::this_thread::yield();
      }
  });
  bool in_order = true;
  for (std::uint64_t i = 0; i < items;)
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

TEST(SpscRing, PassesEverythingInOrderBetweenThreads) {
  expect_everything_in_order(1, 200);
  expect_everything_in_order(7, 2000);
  expect_everything_in_order(255, 200000);
}

}  // namespace
}  // namespace srd
