// SPDX-License-Identifier: Apache-2.0
// Datagrams that nobody honest sent. A quarter of a million of each kind: a million in all.
#include <vector>

#include <gtest/gtest.h>

#include "proto/check.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/proto/random_messages.hpp"

namespace srd::proto {
namespace {

using testing::Generator;
using Bytes = std::vector<std::uint8_t>;

constexpr int kDraws = 250000;

Bytes good_from_node(Generator& random) {
  Bytes buffer(kMaxDatagram);
  const NodeHeader header = testing::any_header(random);
  const auto size = random() % 8 == 0 ? encode(header.from, header.sequence, testing::any_status(random), buffer)
                                      : encode(header.from, header.sequence, testing::any_frame(random), buffer);
  buffer.resize(seal(buffer, *size, header.oldest_held));
  return buffer;
}

bool accepted(const Bytes& datagram) {
  return decode_node_datagram(datagram).has_value() || decode_acknowledgement(datagram).has_value();
}

TEST(HostileDatagrams, RandomBytesAreNotAccepted) {
  Generator random(1);
  for (int i = 0; i < kDraws; ++i) {
    Bytes bytes(static_cast<std::size_t>(random() % 1400));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    ASSERT_FALSE(accepted(bytes)) << i;
  }
}

TEST(HostileDatagrams, TruncatedOnesAreNotAccepted) {
  Generator random(2);
  for (int i = 0; i < kDraws;) {
    const Bytes good = random() % 2 == 0 ? good_from_node(random) : encode_datagram(testing::any_acknowledgement(random));
    ASSERT_TRUE(accepted(good));
    for (int cut = 0; cut < 25; ++cut, ++i)
      ASSERT_FALSE(accepted(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(random() % good.size()))));
  }
}

TEST(HostileDatagrams, DamagedAndReflectedOnesAreNotAccepted) {
  Generator random(3);
  for (int i = 0; i < kDraws;) {
    const Bytes from_node = good_from_node(random);
    const Bytes from_host = encode_datagram(testing::any_acknowledgement(random));
    ASSERT_FALSE(decode_acknowledgement(from_node).has_value());
    ASSERT_FALSE(decode_node_datagram(from_host).has_value());
    for (int hit = 0; hit < 25; ++hit, ++i) {
      Bytes bad = random() % 2 == 0 ? from_node : from_host;
      for (auto flips = 1 + random() % 4; flips > 0; --flips)
        bad[static_cast<std::size_t>(random() % bad.size())] ^= static_cast<std::uint8_t>(1u << (random() % 8));
      if (bad == from_node || bad == from_host) continue;
      ASSERT_FALSE(accepted(bad));
    }
  }
}

// The check holds, so everything behind it is reached. What is let through keeps every bound.
TEST(HostileDatagrams, ForgedContentKeepsTheBoundsOrIsRefused) {
  Generator random(4);
  int let_through = 0;
  for (int i = 0; i < kDraws;) {
    const Bytes good = random() % 2 == 0 ? good_from_node(random) : encode_datagram(testing::any_acknowledgement(random));
    for (int hit = 0; hit < 25; ++hit, ++i) {
      Bytes forged = good;
      forged.resize(forged.size() - kCheckBytes);
      for (auto changes = 1 + random() % 6; changes > 0; --changes)
        forged[static_cast<std::size_t>(random() % forged.size())] = static_cast<std::uint8_t>(random());
      if (random() % 4 == 0) forged.resize(static_cast<std::size_t>(random() % forged.size()));
      const std::size_t size = forged.size();
      forged.resize(size + kCheckBytes);
      for (const Direction direction : {Direction::kFromNode, Direction::kFromHost}) {
        append_check(direction, forged, size);
        if (const auto message = decode_node_datagram(forged)) {
          ++let_through;
          ASSERT_TRUE(valid(message->header));
          std::visit([](const auto& content) { ASSERT_TRUE(valid(content)); }, message->content);
        }
        if (const auto acknowledgement = decode_acknowledgement(forged)) {
          ++let_through;
          ASSERT_TRUE(valid(*acknowledgement));
        }
      }
    }
  }
  EXPECT_GT(let_through, 1000);  // or this test would not reach what it is about
}

TEST(HostileDatagrams, AnotherVersionIsNotAccepted) {
  Generator random(5);
  Bytes good = good_from_node(random);
  ASSERT_EQ(good[0], 0x08);  // field 1, version
  ASSERT_EQ(good[1], kWireVersion);
  good[1] = kWireVersion + 1;
  append_check(Direction::kFromNode, good, good.size() - kCheckBytes);
  EXPECT_FALSE(accepted(good));
}

}  // namespace
}  // namespace srd::proto
