// SPDX-License-Identifier: Apache-2.0
#include "host/listen/stream.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace srd::host {
namespace {

using proto::SequenceRange;

proto::CoefficientFrame a_frame(std::uint64_t number) {
  proto::CoefficientFrame frame;
  frame.source_sequence = number;
  return frame;
}

std::vector<std::uint64_t> take_ready(Stream& stream) {
  std::vector<std::uint64_t> out;
  while (const auto ready = stream.ready()) {
    EXPECT_EQ(ready->frame->source_sequence, ready->sequence);
    out.push_back(ready->sequence);
    stream.pop_ready();
  }
  return out;
}

TEST(SequenceSet, AgreesWithASetOfNumbers) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    SequenceSet ranges;
    std::set<std::uint64_t> numbers;
    for (int i = 0; i < 100; ++i) {
      const std::uint64_t begin = random() % 200;
      if (random() % 3 == 0 && numbers.contains(begin)) {
        ranges.remove(begin);
        numbers.erase(begin);
        continue;
      }
      const std::uint64_t end = begin + random() % 5;
      ranges.add({begin, end});
      for (std::uint64_t s = begin; s < end; ++s) numbers.insert(s);
    }
    std::uint64_t before = 0;
    bool first = true;
    for (const SequenceRange& range : ranges.ranges()) {
      ASSERT_LT(range.begin, range.end);
      ASSERT_TRUE(first || range.begin > before);
      before = range.end;
      first = false;
    }
    for (std::uint64_t s = 0; s < 210; ++s) {
      ASSERT_EQ(ranges.contains(s), numbers.contains(s));
      std::uint64_t missing = s;
      while (numbers.contains(missing)) ++missing;
      ASSERT_EQ(ranges.first_missing(s), missing);
    }
    std::uint64_t missing = 0;
    for (std::uint64_t s = 20; s < 190; ++s) missing += numbers.contains(s) ? 0 : 1;
    ASSERT_EQ(ranges.count_missing(20, 190), missing);
  }
}

TEST(Stream, PutsFramesInOrderOnce) {
  Stream stream({}, 0);
  for (const std::uint64_t s : {0, 2, 1, 1, 4, 3, 3, 0}) stream.take(s, a_frame(s));
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(stream.counts().duplicates, 3u);
  EXPECT_EQ(stream.counts().late, 2u);
}

TEST(Stream, WaitsForAGapUntilTheNodeNoLongerHoldsIt) {
  Stream stream({}, 0);
  for (const std::uint64_t s : {0, 1, 5, 6}) stream.take(s, a_frame(s));
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{0, 1}));
  EXPECT_EQ(stream.missing(), 3u);
  stream.give_up_below(4);
  EXPECT_FALSE(stream.ready().has_value());
  stream.take(4, a_frame(4));
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{4, 5, 6}));
  EXPECT_EQ(stream.lost_ranges(), (std::vector<SequenceRange>{{2, 4}}));
  stream.take(2, a_frame(2));
  EXPECT_FALSE(stream.ready().has_value());
}

TEST(Stream, StartsWhereTheNodeStillHolds) {
  Stream stream({}, 100);
  stream.take(100, a_frame(100));
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{100}));
  EXPECT_EQ(stream.counts().lost, 0u);
  const std::vector<SequenceRange> lost{{40, 60}};
  stream.take_lost_ranges(lost);
  stream.take_lost_ranges(lost);
  EXPECT_EQ(stream.lost_ranges(), lost);
  EXPECT_EQ(stream.counts().lost, 20u);
}

TEST(Stream, GoesOnWhereTheRecordEnds) {
  SequenceSet recorded;
  recorded.add({10, 20});
  recorded.add({25, 30});
  Stream stream(recorded, 12);
  for (std::uint64_t s = 18; s < 33; ++s) stream.take(s, a_frame(s));
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{20, 21, 22, 23, 24, 30, 31, 32}));
}

TEST(Stream, AcknowledgesOnlyWhatIsDelivered) {
  Stream stream({}, 0);
  for (const std::uint64_t s : {0, 1, 2, 4, 7}) stream.take(s, a_frame(s));
  proto::Acknowledgement out;
  stream.describe(out);
  EXPECT_EQ(out.first_missing, 0u);  // nothing was taken for the record
  EXPECT_EQ(out.known_end, 8u);
  (void)stream.ready();
  stream.pop_ready();
  stream.describe(out);
  EXPECT_EQ(out.first_missing, 1u);
  (void)take_ready(stream);
  stream.describe(out);
  EXPECT_EQ(out.first_missing, 3u);
  ASSERT_EQ(out.missing.size(), 2u);
  EXPECT_EQ(out.missing[0], (SequenceRange{3, 4}));
  EXPECT_EQ(out.missing[1], (SequenceRange{5, 7}));
  out.of = {*proto::NodeId::make("n"), 1};
  EXPECT_TRUE(valid(out));
}

TEST(Stream, SaysNothingOfWhatDoesNotFitAnAcknowledgement) {
  Stream stream({}, 0);
  for (std::uint64_t s = 1; s < 1000; s += 2) stream.take(s, a_frame(s));
  proto::Acknowledgement out;
  stream.describe(out);
  EXPECT_EQ(out.missing.size(), 40u);
  EXPECT_EQ(out.known_end, 80u);
}

TEST(Stream, BoundsWhatWaitsAndKeepsTheEarliest) {
  Stream stream({}, 0);
  for (std::uint64_t s = 1; s < 3 * Stream::kMaxWaiting; ++s) stream.take(s, a_frame(s));
  EXPECT_EQ(stream.waiting(), Stream::kMaxWaiting);
  // Far ones make place for near ones.
  Stream other({}, 0);
  for (std::uint64_t s = 4 * Stream::kMaxWaiting; s > 0; --s) other.take(s, a_frame(s));
  EXPECT_EQ(other.waiting(), Stream::kMaxWaiting);
  other.take(0, a_frame(0));
  EXPECT_EQ(take_ready(other).size(), Stream::kMaxWaiting + 1);
}

TEST(Stream, GivingUpReleasesWhatWaits) {
  Stream stream({}, 0);
  for (const std::uint64_t s : {1, 3}) stream.take(s, a_frame(s));
  stream.give_up();
  EXPECT_EQ(take_ready(stream), (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(stream.lost_ranges(), (std::vector<SequenceRange>{{0, 1}, {2, 3}}));
  EXPECT_EQ(stream.missing(), 0u);
}

}  // namespace
}  // namespace srd::host
