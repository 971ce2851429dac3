// SPDX-License-Identifier: Apache-2.0
// What the host reads: anything accepted keeps every bound.
#include <cstdlib>

#include "proto/envelope.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/fuzz/checked_input.hpp"
#include "tests/proto/random_messages.hpp"

namespace {

using namespace srd::proto;

void judge(const std::optional<NodeMessage>& message, std::span<const std::uint8_t> datagram) {
  if (!message) return;
  // The key is chosen by the envelope: it must say what the message says.
  const auto envelope = read_envelope(datagram);
  if (envelope && envelope->of != message->header.from) std::abort();
  if (!valid(message->header)) std::abort();
  std::visit(
      [](const auto& content) {
        if (!valid(content)) std::abort();
      },
      message->content);
  if (const auto* frame = std::get_if<CoefficientFrame>(&message->content)) (void)standard_deviations(frame->information);
}

void try_message(std::span<const std::uint8_t> bytes) {
  const auto with_check = testing::with_check(Direction::kFromNode, bytes),
             with_tag = testing::with_tag(Direction::kFromNode, bytes);
  judge(decode_node_datagram(with_check), with_check);
  judge(decode_node_datagram(with_tag, &testing::fuzz_key()), with_tag);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::span input(bytes, size);
  (void)decode_node_datagram(input);
  if (decode_node_datagram(input, &testing::fuzz_key())) std::abort();  // nobody without the key makes a tag
  try_message(input);
  if (size < 2) return 0;
  // A good message of a kind and seed that the fuzzer chooses, then changed.
  testing::Generator random(bytes[1]);
  std::vector<std::uint8_t> good(kMaxDatagram);
  const NodeHeader header = testing::any_header(random);
  const auto encoded = bytes[0] % 2 == 0 ? encode(header.from, header.sequence, testing::any_frame(random), good)
                                         : encode(header.from, header.sequence, testing::any_status(random), good);
  good.resize(*encoded);
  try_message(testing::changed(std::move(good), input.subspan(2)));
  return 0;
}
