// SPDX-License-Identifier: Apache-2.0
// What the node reads: anything accepted keeps every bound.
#include <cstdlib>

#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/fuzz/checked_input.hpp"
#include "tests/proto/random_messages.hpp"

namespace {

using namespace srd::proto;

void try_message(std::span<const std::uint8_t> bytes) {
  const auto heard = decode_acknowledgement(testing::with_check(Direction::kFromHost, bytes));
  if (heard && !valid(*heard)) std::abort();
  const auto tagged = testing::with_tag(Direction::kFromHost, bytes);
  const auto proved = decode_acknowledgement(tagged, &testing::fuzz_key());
  if (proved && !valid(*proved)) std::abort();
  const auto welcome = decode_welcome(tagged, testing::fuzz_key());
  if (welcome && welcome->of.node.view().empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::span input(bytes, size);
  (void)decode_acknowledgement(input);
  // Nobody without the key makes a tag.
  if (decode_acknowledgement(input, &testing::fuzz_key()) || decode_welcome(input, testing::fuzz_key())) std::abort();
  try_message(input);
  if (size < 1) return 0;
  testing::Generator random(bytes[0]);
  const auto acknowledgement = testing::any_acknowledgement(random);
  std::vector<std::uint8_t> welcome =
      encode_datagram(Welcome{acknowledgement.of, random(), 1, random_challenge(), {}}, testing::fuzz_key());
  welcome.resize(welcome.size() - kMostEndBytes);
  try_message(testing::changed(std::move(welcome), input.subspan(1)));
  std::vector<std::uint8_t> good = encode_datagram(acknowledgement);
  good.resize(good.size() - kCheckBytes);
  try_message(testing::changed(std::move(good), input.subspan(1)));
  return 0;
}
