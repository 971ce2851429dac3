// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/sender.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/transmit/frame_store.hpp"
#include "proto/host_codec.hpp"
#include "tests/fakes/allocation_gauge.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kSecond = 1'000'000'000;

SenderOptions options_with(std::size_t frames) {
  SenderOptions options;
  options.from = {*proto::NodeId::make("node"), 42};
  options.ring_frames = frames;
  return options;
}

proto::CoefficientFrame a_frame(int parameters = 12) {
  proto::CoefficientFrame frame;
  frame.status = proto::FrameStatus::kOk;
  frame.model.modes = dsp::ModeList::standard(parameters).value();
  frame.model.lx = frame.model.ly = 200;
  frame.refractive_index = 1.333f;
  frame.coefficients.setConstant(parameters, 1);
  frame.information.size = parameters;
  for (int i = 0; i < parameters; ++i) {
    frame.information.scale[static_cast<std::size_t>(i)] = 1;
    frame.information.entries[proto::InformationFactor::index(i, i)] = 1;
  }
  return frame;
}

// Everything due at a time.
std::vector<proto::NodeMessage> sent_at(Sender& sender, std::int64_t now) {
  std::vector<proto::NodeMessage> out;
  for (auto datagram = sender.next(now); !datagram.empty(); datagram = sender.next(now)) {
    const auto message = proto::decode_node_datagram(datagram);
    EXPECT_TRUE(message.has_value());
    if (message) out.push_back(*message);
  }
  return out;
}

std::vector<std::uint64_t> frames_of(const std::vector<proto::NodeMessage>& messages) {
  std::vector<std::uint64_t> out;
  for (const auto& message : messages)
    if (std::holds_alternative<proto::CoefficientFrame>(message.content)) out.push_back(message.header.sequence);
  return out;
}

proto::Acknowledgement answer(std::uint64_t serial, std::uint64_t first_missing, std::uint64_t known_end) {
  proto::Acknowledgement out;
  out.of = {*proto::NodeId::make("node"), 42};
  out.session = 7;
  out.serial = serial;
  out.first_missing = first_missing;
  out.known_end = known_end;
  return out;
}

void give(Sender& sender, const proto::Acknowledgement& acknowledgement, std::int64_t now) {
  sender.receive(proto::encode_datagram(acknowledgement), now);
}

// The host's end of a keyed link.
struct KeyedHost {
  proto::Key of_node{std::array<std::uint8_t, proto::Key::kBytes>{7}};
  proto::Challenge challenge{9};
  std::optional<proto::Key> session;

  // The welcome for a hello.
  std::vector<std::uint8_t> welcome(std::span<const std::uint8_t> datagram) {
    const auto hello = proto::decode_node_datagram(datagram, &of_node);
    if (!hello || !std::holds_alternative<proto::Hello>(hello->content)) return {};
    const auto& asked = std::get<proto::Hello>(hello->content).challenge;
    session = proto::session_key(of_node, asked, challenge, hello->header.from);
    return proto::encode_datagram(
        proto::Welcome{.of = hello->header.from, .session = 7, .serial = 1, .from_node = asked, .from_host = challenge},
        of_node);
  }
  [[nodiscard]] std::vector<std::uint8_t> answer(const proto::Acknowledgement& acknowledgement) const {
    return proto::encode_datagram(acknowledgement, &*session);
  }
};

struct KeyedSender {
  KeyedHost host;
  Sender sender;
  KeyedSender() : sender(options(host)) {}
  static SenderOptions options(const KeyedHost& host) {
    SenderOptions out = options_with(100);
    out.key = host.of_node;
    return out;
  }
  // Numbers of the frames due now that hold under the session.
  std::vector<std::uint64_t> frames_at(std::int64_t now) {
    std::vector<std::uint64_t> out;
    for (auto due = sender.next(now); !due.empty(); due = sender.next(now))
      if (const auto message = proto::decode_node_datagram(due, &*host.session))
        if (std::holds_alternative<proto::CoefficientFrame>(message->content)) out.push_back(message->header.sequence);
    return out;
  }
};

TEST(SenderWithAKey, SaysNothingButHelloBeforeTheHostHasAnswered) {
  KeyedSender keyed;
  Sender& sender = keyed.sender;
  ASSERT_TRUE(sender.push(a_frame()));
  std::int64_t now = kSecond;
  EXPECT_FALSE(keyed.host.welcome(sender.next(now)).empty());  // lost on its way
  EXPECT_TRUE(sender.next(now).empty());
  EXPECT_TRUE(sender.status(now).empty());
  now += 200 * kMillisecond;
  const auto again = sender.next(now);
  const auto welcome = keyed.host.welcome(again);
  ASSERT_FALSE(welcome.empty());
  sender.receive(welcome, now);
  EXPECT_EQ(keyed.frames_at(now), std::vector<std::uint64_t>{0});
  sender.receive(keyed.host.answer(answer(1, 1, 1)), now);
  EXPECT_EQ(sender.unacknowledged(), 0u);
}

TEST(SenderWithAKey, BelievesNoAnswerButTheSessionsOwnAndEachOnce) {
  KeyedSender keyed;
  Sender& sender = keyed.sender;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(sender.push(a_frame()));
  const auto welcome = keyed.host.welcome(sender.next(kSecond));
  sender.receive(welcome, kSecond);
  EXPECT_EQ(keyed.frames_at(kSecond).size(), 10u);
  const auto ignored = [&](const std::vector<std::uint8_t>& datagram) {
    const std::uint64_t before = sender.counts().ignored;
    sender.receive(datagram, kSecond);
    return sender.counts().ignored == before + 1 && sender.unacknowledged() == 10;
  };
  EXPECT_TRUE(ignored(welcome)) << "a second session for one hello";
  EXPECT_TRUE(ignored(proto::encode_datagram(answer(1, 10, 10))));
  EXPECT_TRUE(ignored(proto::encode_datagram(answer(1, 10, 10), &keyed.host.of_node)));
  const auto first = keyed.host.answer(answer(5, 0, 10));
  sender.receive(first, kSecond);
  EXPECT_EQ(sender.counts().acknowledgements, 1u);
  EXPECT_TRUE(ignored(first)) << "replayed";
  EXPECT_TRUE(ignored(keyed.host.answer(answer(4, 10, 10)))) << "older";
  sender.receive(keyed.host.answer(answer(6, 10, 10)), kSecond);
  EXPECT_EQ(sender.unacknowledged(), 0u);
}

// The host that answered once has started anew: it knows no session, and says nothing.
TEST(SenderWithAKey, TagsAFrameAnewUnderTheNextSession) {
  KeyedSender keyed;
  Sender& sender = keyed.sender;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(sender.push(a_frame()));
  sender.receive(keyed.host.welcome(sender.next(kSecond)), kSecond);
  EXPECT_EQ(keyed.frames_at(kSecond).size(), 10u);
  const proto::Key first = *keyed.host.session;
  keyed.host.challenge = {10};
  std::vector<std::uint8_t> welcome;
  std::int64_t now = kSecond;
  for (; welcome.empty() && now < 4 * kSecond; now += kMillisecond)
    for (auto due = sender.next(now); !due.empty() && welcome.empty(); due = sender.next(now))
      welcome = keyed.host.welcome(due);
  ASSERT_FALSE(welcome.empty());
  EXPECT_LE(now, 2 * kSecond + 2 * kMillisecond) << "a second of silence";
  sender.receive(welcome, now);
  EXPECT_FALSE(first == *keyed.host.session);
  EXPECT_EQ(keyed.frames_at(now).size(), 10u) << "at once, all of them";
}

TEST(FrameStore, KeepsBytesInAnyOrderOfSizes) {
  std::mt19937_64 random(1);
  FrameStore store(50, 4000);
  std::vector<std::vector<std::uint8_t>> kept;
  std::uint64_t first = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(1 + random() % 300), static_cast<std::uint8_t>(i));
    while (!store.fits(bytes.size())) {
      store.drop_oldest();
      kept.erase(kept.begin());
      ++first;
    }
    ASSERT_TRUE(store.append(bytes));
    kept.push_back(bytes);
    if (random() % 5 == 0)
      for (auto drops = random() % (kept.size() + 1); drops > 0; --drops) {
        store.drop_oldest();
        kept.erase(kept.begin());
        ++first;
      }
    ASSERT_EQ(store.oldest(), first);
    ASSERT_EQ(store.next(), first + kept.size());
    for (std::uint64_t s = first; s < store.next(); ++s) {
      const auto stored = store.bytes(s);
      ASSERT_TRUE(std::equal(stored.begin(), stored.end(), kept[static_cast<std::size_t>(s - first)].begin(),
                             kept[static_cast<std::size_t>(s - first)].end()));
      ASSERT_EQ(store.sequence_at(store.index(s)), s);
    }
  }
  EXPECT_FALSE(FrameStore(10, 100).fits(101));
}

TEST(Sender, SaysWhoItIsFirstThenSendsEachNewFrameOnce) {
  Sender sender(options_with(100));
  const auto hello = sent_at(sender, 0);
  ASSERT_EQ(hello.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<proto::NodeStatus>(hello[0].content));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(sender.push(a_frame()));
  EXPECT_EQ(frames_of(sent_at(sender, kMillisecond)), (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(sent_at(sender, 2 * kMillisecond).empty());
}

TEST(Sender, SendsAgainWhatTheHostLacksAndNothingElse) {
  Sender sender(options_with(100));
  for (int i = 0; i < 6; ++i) sender.push(a_frame());
  (void)sent_at(sender, 0);
  proto::Acknowledgement lacks = answer(1, 1, 5);
  lacks.missing.push({1, 3});
  give(sender, lacks, 40 * kMillisecond);
  // 1 and 2 are named missing; 5 may still be on its way.
  EXPECT_EQ(frames_of(sent_at(sender, 40 * kMillisecond)), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(sender.oldest_held(), 1u);
  give(sender, answer(2, 6, 6), 60 * kMillisecond);
  EXPECT_EQ(sender.unacknowledged(), 0u);
  EXPECT_TRUE(frames_of(sent_at(sender, 10 * kSecond)).empty());
}

TEST(Sender, TakesBackWhatANewHostDoesNotHave) {
  Sender sender(options_with(100));
  for (int i = 0; i < 4; ++i) sender.push(a_frame());
  (void)sent_at(sender, 0);
  proto::Acknowledgement has_later = answer(1, 0, 4);
  has_later.missing.push({0, 1});
  give(sender, has_later, 20 * kMillisecond);
  EXPECT_EQ(frames_of(sent_at(sender, 300 * kMillisecond)), (std::vector<std::uint64_t>{0}));
  proto::Acknowledgement anew = answer(1, 0, 0);
  anew.session = 8;
  give(sender, anew, 310 * kMillisecond);
  auto again = frames_of(sent_at(sender, 310 * kMillisecond));
  EXPECT_EQ(again, (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST(Sender, IgnoresStaleForeignAndImpossibleAnswers) {
  Sender sender(options_with(100));
  for (int i = 0; i < 4; ++i) sender.push(a_frame());
  (void)sent_at(sender, 0);
  proto::Acknowledgement other = answer(1, 4, 4);
  other.of.boot = 43;
  give(sender, other, kMillisecond);
  other = answer(1, 4, 4);
  other.of.node = *proto::NodeId::make("other");
  give(sender, other, kMillisecond);
  give(sender, answer(1, 5, 5), kMillisecond);  // of frames that were never sent
  sender.receive(std::vector<std::uint8_t>(100, 3), kMillisecond);
  EXPECT_EQ(sender.unacknowledged(), 4u);
  EXPECT_EQ(sender.counts().ignored, 4u);
  // An answer that was overtaken by a newer one cannot make frames missing again.
  give(sender, answer(5, 0, 4), 50 * kMillisecond);
  proto::Acknowledgement stale = answer(4, 0, 4);
  stale.missing.push({0, 4});
  give(sender, stale, 60 * kMillisecond);
  EXPECT_TRUE(frames_of(sent_at(sender, 60 * kMillisecond)).empty());
}

TEST(Sender, AnnouncesWhatAFullRingOverwrote) {
  Sender sender(options_with(10));
  for (int i = 0; i < 25; ++i) ASSERT_TRUE(sender.push(a_frame()));
  EXPECT_EQ(sender.counts().lost, 15u);
  EXPECT_EQ(sender.oldest_held(), 15u);
  const auto messages = sent_at(sender, 0);
  ASSERT_TRUE(std::holds_alternative<proto::NodeStatus>(messages[0].content));
  const auto& status = std::get<proto::NodeStatus>(messages[0].content);
  ASSERT_EQ(status.lost_ranges.size(), 1u);
  EXPECT_EQ(status.lost_ranges[0], (proto::SequenceRange{0, 15}));
  EXPECT_EQ(status.lost, 15u);
  EXPECT_EQ(status.held, 10u);
  for (const auto& message : messages) EXPECT_EQ(message.header.oldest_held, 15u);
  EXPECT_EQ(frames_of(messages).front(), 15u);
}

TEST(Sender, ManyLostRangesAreStillAllCovered) {
  Sender sender(options_with(4));
  std::vector<std::uint64_t> lost;
  std::int64_t now = 0;
  std::uint64_t serial = 0;
  for (std::uint64_t s = 0; s < 400; ++s) {
    sender.push(a_frame());
    (void)sent_at(sender, now += 5 * kMillisecond);
    // Every tenth frame is delivered before it would be lost.
    if (s % 10 == 9) give(sender, answer(++serial, s + 1, s + 1), now);
  }
  const auto status = proto::decode_node_datagram(sender.status(now));
  const auto& ranges = std::get<proto::NodeStatus>(status->content).lost_ranges;
  EXPECT_EQ(ranges.size(), 16u);
  std::uint64_t covered = 0;
  for (const auto& range : ranges) covered += range.size();
  EXPECT_GE(covered, sender.counts().lost);
  EXPECT_EQ(ranges[0].begin, 0u);
}

TEST(Sender, AFrameThatIsNotANumberIsKeptAsFailed) {
  Sender sender(options_with(10));
  proto::CoefficientFrame frame = a_frame();
  frame.coefficients[3] = std::nanf("");
  frame.corners_found = 17;
  ASSERT_TRUE(sender.push(frame));
  const auto messages = sent_at(sender, 0);
  const auto& sent = std::get<proto::CoefficientFrame>(messages.back().content);
  EXPECT_FALSE(sent.has_surface());
  EXPECT_EQ(sent.status, proto::FrameStatus::kFailed);
  EXPECT_EQ(sent.corners_found, 17u);
}

TEST(Sender, StatusComesEverySecondAndKeepsTheCallersWords) {
  Sender sender(options_with(10));
  proto::NodeStatus status;
  status.state = proto::NodeState::kTracking;
  status.capture_hz = 50;
  status.dropped_late = 3;
  sender.set_status(status, 5 * kSecond);
  int statuses = 0;
  for (std::int64_t now = 0; now < 10 * kSecond; now += 10 * kMillisecond)
    for (const auto& message : sent_at(sender, now)) {
      const auto& said = std::get<proto::NodeStatus>(message.content);
      EXPECT_EQ(said.state, proto::NodeState::kTracking);
      EXPECT_EQ(said.dropped_late, 3u);
      EXPECT_EQ(said.stamp.wall_time_ns, now + 5 * kSecond);
      ++statuses;
    }
  EXPECT_EQ(statuses, 10);
}

TEST(Sender, DoesNotFloodAHostThatIsAway) {
  SenderOptions options = options_with(10000);
  options.window = 64;
  Sender sender(options);
  for (int i = 0; i < 10000; ++i) sender.push(a_frame(1));
  std::size_t sent = 0;
  for (std::int64_t now = 0; now < 60 * kSecond; now += 2 * kMillisecond) sent += sent_at(sender, now).size();
  EXPECT_LE(sent, 60u * (2 * 64 + 1) + 64);
}

TEST(Sender, DoesNotAllocate) {
  Sender sender(options_with(500));
  const proto::CoefficientFrame frame = a_frame();
  std::vector<std::vector<std::uint8_t>> answers;
  for (std::uint64_t i = 1; i <= 100; ++i) answers.push_back(proto::encode_datagram(answer(i, 8 * i, 10 * i)));
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  const fakes::AllocationGauge gauge;
  std::int64_t now = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    now += 5 * kMillisecond;
    sender.push(frame);
    while (!sender.next(now).empty()) {}
    if (i % 10 == 9) sender.receive(answers[i / 10], now);
  }
  EXPECT_EQ(gauge.count(), 0);
  EXPECT_GT(sender.counts().acknowledgements, 90u);
}

}  // namespace
}  // namespace srd::firmware
