// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/link_key.hpp"

#include <algorithm>

namespace srd::firmware {

std::span<const std::uint8_t> LinkKey::hello(std::int64_t now, std::int64_t heard_ns, std::uint64_t next, std::uint64_t oldest,
                                             std::span<std::uint8_t> buffer) {
  if (!of_node_ || (session_ && now - std::max(heard_ns, since_ns_) <= silence_)) return {};
  if (sent_ && now - sent_ns_ < interval_) return {};
  if (!asked_) {
    asked_ = proto::random_challenge();
    asked_ns_ = now;
  }
  // Each copy says the same: whichever is answered, there is one session.
  const proto::Hello hello{.stamp = {asked_ns_, ClockId::kMonotonic, 0, 0}, .challenge = *asked_};
  const auto bytes = proto::encode(from_, next, hello, buffer);
  if (!bytes) return {};
  sent_ = true;
  sent_ns_ = now;
  return buffer.first(proto::seal(buffer, *bytes, oldest, &*of_node_));
}

bool LinkKey::take_welcome(std::span<const std::uint8_t> datagram, std::int64_t now) {
  if (!asked_) return false;
  const auto welcome = proto::decode_welcome(datagram, *of_node_);
  if (!welcome || welcome->of != from_ || welcome->from_node != *asked_) return false;
  session_ = proto::session_key(*of_node_, *asked_, welcome->from_host, from_);
  asked_.reset();
  since_ns_ = now;
  return true;
}

}  // namespace srd::firmware
