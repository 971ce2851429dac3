// SPDX-License-Identifier: Apache-2.0
// What the receiver does with datagrams that a node did not send, or not now.
#include "host/listen/receiver.hpp"

#include <random>

#include <gtest/gtest.h>

#include "host/listen/status_line.hpp"
#include "proto/check.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/proto/random_messages.hpp"

namespace srd::host {
namespace {

using proto::testing::Generator;
using Bytes = std::vector<std::uint8_t>;

Bytes datagram_of(const proto::NodeHeader& header, const proto::CoefficientFrame& frame) {
  Bytes buffer(proto::kMaxDatagram);
  const auto size = proto::encode(header.from, header.sequence, frame, buffer);
  buffer.resize(proto::seal(buffer, *size, header.oldest_held));
  return buffer;
}

Address somewhere() { return Address::parse("127.0.0.1:9", "test").value(); }

std::size_t waiting_in(const Receiver& receiver) {
  std::size_t sum = 0;
  for (const auto& [id, source] : receiver.sources()) sum += source.stream.waiting();
  return sum;
}

// Damaged, cut, random and reflected ones: a million.
TEST(Receiver, AcceptsNothingOfAMillionBadDatagrams) {
  Generator random(1);
  Receiver receiver({}, 1);
  const Address from = somewhere();
  std::uint64_t given = 0;
  while (given < 1'000'000) {
    const Bytes good = datagram_of(proto::testing::any_header(random), proto::testing::any_frame(random));
    const Bytes reflected = proto::encode_datagram(proto::testing::any_acknowledgement(random));
    receiver.receive(reflected, from, 0);
    ++given;
    for (int i = 0; i < 99; ++i, ++given) {
      Bytes bad = good;
      switch (random() % 3) {
        case 0: bad.resize(random() % bad.size()); break;
        case 1: bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1 + random() % 255); break;
        default:
          for (auto& byte : bad) byte = static_cast<std::uint8_t>(random());
      }
      receiver.receive(bad, from, 0);
    }
  }
  EXPECT_EQ(receiver.counts().rejected, given);
  EXPECT_TRUE(receiver.sources().empty());
  EXPECT_FALSE(receiver.ready().has_value());
  EXPECT_FALSE(receiver.answer_due());
}

TEST(Receiver, ReplayedDatagramsAddNoRows) {
  Generator random(2);
  Receiver receiver({}, 1);
  const proto::BootId boot{*proto::NodeId::make("n"), 1};
  std::vector<Bytes> sent;
  for (std::uint64_t s = 0; s < 200; ++s) sent.push_back(datagram_of({boot, s, 0}, proto::testing::any_frame(random, 5)));
  std::uint64_t rows = 0;
  for (int round = 0; round < 50; ++round)
    for (std::size_t i = 0; i < sent.size(); ++i) {
      receiver.receive(sent[round == 0 ? i : random() % sent.size()], somewhere(), 0);
      for (; receiver.ready(); receiver.pop_ready()) ++rows;
    }
  EXPECT_EQ(rows, 200u);
  EXPECT_EQ(receiver.sources().at(boot).stream.counts().duplicates, 49u * 200);
}

TEST(Receiver, TwoLivingNodesOfOneIdAreTold) {
  Generator random(3);
  Receiver receiver({}, 1);
  const auto id = *proto::NodeId::make("n");
  const auto at = [](const char* address) { return Address::parse(address, "test").value(); };
  constexpr std::int64_t kFrame = 20'000'000;  // ns
  for (std::uint64_t s = 0; s < 300; ++s) {
    const auto now = static_cast<std::int64_t>(s) * kFrame;
    receiver.receive(datagram_of({{id, 1}, s, 0}, proto::testing::any_frame(random, 5)), at("10.0.0.1:9"), now);
    if (s >= 50) receiver.receive(datagram_of({{id, 2}, s, 0}, proto::testing::any_frame(random, 5)), at("10.0.0.2:9"), now);
    const bool long_enough = now >= 50 * kFrame + Receiver::kOldBootIsSilentAfter;
    EXPECT_EQ(receiver.shared_ids().size(), long_enough ? 1u : 0u) << s;
  }
  const auto text = shared_id_text(receiver, receiver.shared_ids().front());
  for (const char* part : {"'n'", "10.0.0.1:9 (b0000000000000001)", "10.0.0.2:9 (b0000000000000002)", "node.id"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_TRUE(receiver.sources().at({id, 1}).shares_id);
  EXPECT_FALSE(receiver.sources().at({id, 2}).shares_id);
}

// What a node sends again of an old boot, however late, is none that it measures now.
TEST(Receiver, ANodeThatCameBackIsNoSecondOne) {
  Generator random(4);
  Receiver receiver({}, 1);
  const auto id = *proto::NodeId::make("n");
  std::vector<Bytes> old;
  for (std::uint64_t s = 0; s < 100; ++s) old.push_back(datagram_of({{id, 1}, s, 0}, proto::testing::any_frame(random, 5)));
  for (const Bytes& datagram : old) receiver.receive(datagram, somewhere(), 0);
  for (std::uint64_t s = 0; s < 500; ++s) {
    const auto now = static_cast<std::int64_t>(s) * 20'000'000;
    receiver.receive(datagram_of({{id, 2}, s, 0}, proto::testing::any_frame(random, 5)), somewhere(), now);
    receiver.receive(old[s % old.size()], somewhere(), now);
  }
  EXPECT_TRUE(receiver.shared_ids().empty());
}

// Someone without a key can make whole datagrams; they must not eat the memory.
TEST(Receiver, ForgedSourcesAndGapsStayBounded) {
  Generator random(3);
  Receiver receiver({}, 1);
  const proto::CoefficientFrame frame = proto::testing::any_frame(random, 1);
  for (int i = 0; i < 100'000; ++i) {
    const proto::BootId boot{*proto::NodeId::make("n" + std::to_string(random() % 2000)), random() % 3};
    receiver.receive(datagram_of({boot, random() % (std::uint64_t{1} << 40), 0}, frame), somewhere(), 0);
  }
  EXPECT_LE(receiver.sources().size(), Receiver::kMaxSources);
  EXPECT_LE(waiting_in(receiver), Receiver::kMaxWaiting + Receiver::kMaxSources);
  EXPECT_GT(receiver.counts().no_room, 0u);
  for (const auto& [to, datagram] : receiver.acknowledgements())
    EXPECT_TRUE(proto::decode_acknowledgement(datagram).has_value());
}

TEST(Receiver, AnswersOnlyWhomItHeard) {
  Generator random(4);
  Receiver receiver({}, 77);
  const proto::BootId boot{*proto::NodeId::make("n"), 5};
  EXPECT_TRUE(receiver.acknowledgements().empty());
  receiver.receive(datagram_of({boot, 0, 0}, proto::testing::any_frame(random)), somewhere(), 0);
  // Not recorded yet: nothing is acknowledged.
  auto answers = receiver.acknowledgements();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_TRUE(answers[0].first == somewhere());
  EXPECT_EQ(proto::decode_acknowledgement(answers[0].second)->first_missing, 0u);
  ASSERT_TRUE(receiver.ready().has_value());
  receiver.pop_ready();
  EXPECT_TRUE(receiver.acknowledgements().empty());
  answers = receiver.acknowledgements(true);
  ASSERT_EQ(answers.size(), 1u);
  const auto heard = proto::decode_acknowledgement(answers[0].second);
  EXPECT_EQ(heard->first_missing, 1u);
  EXPECT_EQ(heard->of, boot);
  EXPECT_EQ(heard->session, 77u);
}

}  // namespace
}  // namespace srd::host
