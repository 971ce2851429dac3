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
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::span input(bytes, size);
  (void)decode_acknowledgement(input);
  try_message(input);
  if (size < 1) return 0;
  testing::Generator random(bytes[0]);
  std::vector<std::uint8_t> good = encode_datagram(testing::any_acknowledgement(random));
  good.resize(good.size() - kCheckBytes);
  try_message(testing::changed(std::move(good), input.subspan(1)));
  return 0;
}
