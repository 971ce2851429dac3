// SPDX-License-Identifier: Apache-2.0
// Keys, tags and envelopes against what another program computed, and against each other.
#include "proto/key.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "proto/ending.hpp"
#include "proto/envelope.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/proto/random_messages.hpp"

namespace srd::proto {
namespace {

using testing::Generator;
using Bytes = std::vector<std::uint8_t>;

Key key_of(std::uint8_t first, std::uint8_t step = 1) {
  std::array<std::uint8_t, Key::kBytes> bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(first + step * i);
  return Key(bytes);
}

Challenge challenge_of(std::uint8_t first) {
  Challenge out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(first + i);
  return out;
}

template <class Content>
Bytes sealed(const NodeHeader& header, const Content& content, const Key* key) {
  Bytes buffer(kMaxDatagram);
  const auto size = encode(header.from, header.sequence, content, buffer);
  buffer.resize(seal(buffer, *size, header.oldest_held, key));
  return buffer;
}

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

// python3: hashlib.blake2b(challenge + challenge + boot.to_bytes(8, "little") + b"cam-1", key=key, digest_size=32)
TEST(Key, OfASessionIsTheOneThatThePageDescribes) {
  const BootId of{*NodeId::make("cam-1"), 0x0123456789abcdef};
  EXPECT_EQ(hexadecimal(session_key(key_of(0), challenge_of(100), challenge_of(200), of).bytes()),
            "af890e9c3aac50f04b7d9ea4708b3f08207e5bc4a9d1592c81eac35996a6fc1c");
}

// python3: hashlib.blake2b(b"N" + bytes([10]) + message, key=key, digest_size=16)
TEST(Key, TagIsTheOneThatThePageDescribes) {
  const Key key = key_of(0);
  const Bytes message{0x08, 1, 0x12, 1, 'n', 0x52, 2, 0x08, 1};  // version, node, a status
  Bytes datagram = message;
  datagram.resize(message.size() + end_bytes(&key));
  ASSERT_EQ(append_end(&key, Direction::kFromNode, datagram, message.size()), datagram.size());
  EXPECT_EQ(hexadecimal(std::span(datagram).last(18)), "72101357af5e86d18a687f5f2c5c18409293");
}

TEST(Key, EveryPartOfASessionChangesItsKey) {
  const BootId of{*NodeId::make("n"), 1};
  const Key key = session_key(key_of(0), challenge_of(1), challenge_of(2), of);
  EXPECT_EQ(key, session_key(key_of(0), challenge_of(1), challenge_of(2), of));
  EXPECT_FALSE(key == session_key(key_of(1), challenge_of(1), challenge_of(2), of));
  EXPECT_FALSE(key == session_key(key_of(0), challenge_of(3), challenge_of(2), of));
  EXPECT_FALSE(key == session_key(key_of(0), challenge_of(1), challenge_of(3), of));
  EXPECT_FALSE(key == session_key(key_of(0), challenge_of(2), challenge_of(1), of));
  EXPECT_FALSE(key == session_key(key_of(0), challenge_of(1), challenge_of(2), {*NodeId::make("n"), 2}));
  EXPECT_FALSE(key == session_key(key_of(0), challenge_of(1), challenge_of(2), {*NodeId::make("m"), 1}));
  EXPECT_NE(random_challenge(), random_challenge());
}

TEST(Key, IsWipedFromMemoryWhenItGoes) {
  alignas(Key) std::array<std::uint8_t, sizeof(Key)> room{};
  const Key* key = new (room.data()) Key(key_of(1));
  EXPECT_NE(room, (std::array<std::uint8_t, sizeof(Key)>{}));
  key->~Key();
  EXPECT_EQ(room, (std::array<std::uint8_t, sizeof(Key)>{}));
}

TEST(KeyedDatagram, ComesBackUnderItsKeyAlone) {
  Generator random(1);
  const Key key = key_of(1), other = key_of(2);
  for (int i = 0; i < 300; ++i) {
    const NodeHeader header = testing::any_header(random);
    const Hello hello{.stamp = testing::any_stamp(random), .challenge = random_challenge()};
    const Bytes datagram = i % 3 == 0   ? sealed(header, testing::any_frame(random), &key)
                           : i % 3 == 1 ? sealed(header, testing::any_status(random), &key)
                                        : sealed(header, hello, &key);
    const auto back = decode_node_datagram(datagram, &key);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->header, header);
    if (i % 3 == 2) {
      ASSERT_TRUE(std::holds_alternative<Hello>(back->content));
      EXPECT_EQ(std::get<Hello>(back->content).challenge, hello.challenge);
    }
    EXPECT_EQ(back->content.index(), static_cast<std::size_t>(i % 3));
    EXPECT_FALSE(decode_node_datagram(datagram, &other).has_value());
    EXPECT_FALSE(decode_node_datagram(datagram).has_value());
    const auto envelope = read_envelope(datagram);
    ASSERT_TRUE(envelope.has_value());
    EXPECT_EQ(envelope->of, header.from);
    EXPECT_EQ(static_cast<int>(envelope->content), i % 3 == 0 ? 9 : i % 3 == 1 ? 10 : 16);
    const auto acknowledgement = testing::any_acknowledgement(random);
    const Bytes answer = encode_datagram(acknowledgement, &key);
    EXPECT_EQ(decode_acknowledgement(answer, &key), acknowledgement);
    EXPECT_FALSE(decode_acknowledgement(answer, &other).has_value());
    EXPECT_FALSE(decode_acknowledgement(answer).has_value());
    const Welcome welcome{header.from, 1, 2, random_challenge(), random_challenge()};
    EXPECT_EQ(decode_welcome(encode_datagram(welcome, key), key), welcome);
    EXPECT_FALSE(decode_welcome(encode_datagram(welcome, key), other).has_value());
    EXPECT_FALSE(decode_welcome(answer, key).has_value());
    EXPECT_FALSE(decode_acknowledgement(encode_datagram(welcome, key), &key).has_value());
  }
}

// A check says nothing where a key is wanted, and a tag nothing where none is known.
TEST(KeyedDatagram, IsNoneWithACheckInPlaceOfItsTag) {
  Generator random(2);
  const Key key = key_of(1);
  const NodeHeader header = testing::any_header(random);
  EXPECT_FALSE(decode_node_datagram(sealed(header, testing::any_frame(random), nullptr), &key).has_value());
  Bytes both = sealed(header, testing::any_frame(random), &key);
  both.resize(both.size() + kCheckBytes);
  append_check(Direction::kFromNode, both, both.size() - kCheckBytes);
  EXPECT_FALSE(decode_node_datagram(both, &key).has_value());
}

TEST(KeyedDatagram, DamagedCutAndReflectedOnesAreNone) {
  Generator random(3);
  const Key key = key_of(1);
  for (int i = 0; i < 20000;) {
    const Bytes from_node = sealed(testing::any_header(random), testing::any_frame(random), &key);
    const Bytes from_host = encode_datagram(testing::any_acknowledgement(random), &key);
    ASSERT_FALSE(decode_acknowledgement(from_node, &key).has_value());
    ASSERT_FALSE(decode_node_datagram(from_host, &key).has_value());
    for (int hit = 0; hit < 20; ++hit, ++i) {
      const Bytes& good = random() % 2 == 0 ? from_node : from_host;
      Bytes bad = good;
      if (random() % 3 == 0)
        bad.resize(random() % bad.size());
      else
        bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1u << (random() % 8));
      ASSERT_FALSE(decode_node_datagram(bad, &key).has_value() || decode_acknowledgement(bad, &key).has_value());
    }
  }
}

TEST(Envelope, OfWhatIsNoMessageIsNone) {
  Generator random(4);
  EXPECT_FALSE(read_envelope({}).has_value());
  EXPECT_FALSE(read_envelope(Bytes{0x08, 0x01}).has_value());                               // no node
  EXPECT_FALSE(read_envelope(Bytes{0x12, 0x02, 'n'}).has_value());                          // cut
  EXPECT_FALSE(read_envelope(Bytes{0x12, 0x01, ' '}).has_value());                          // no name
  EXPECT_FALSE(read_envelope(Bytes{0x12, 0x01, 'n', 0x4A, 0, 0x52, 0}).has_value());        // a frame and a status
  EXPECT_FALSE(read_envelope(Bytes{0x12, 0x01, 'n', 0x0B}).has_value());                    // a group
  EXPECT_FALSE(read_envelope(Bytes(30, 0xFF)).has_value());                                 // a number without an end
  EXPECT_FALSE(read_envelope(Bytes{0x12, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 'n'}).has_value());  // 4 GB of name
  EXPECT_TRUE(read_envelope(Bytes{0x12, 0x01, 'n', 0x4A, 0}).has_value());
  for (int i = 0; i < 100000; ++i) {
    Bytes bytes(static_cast<std::size_t>(random() % 60));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    (void)read_envelope(bytes);
  }
}

}  // namespace
}  // namespace srd::proto
