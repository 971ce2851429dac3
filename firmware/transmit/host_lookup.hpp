// SPDX-License-Identifier: Apache-2.0
// The host's addresses, looked up in a thread of its own: a name is known only when the network is up, which may be later than
// the board, and a lookup that nobody answers blocks for many seconds, for which neither sending nor stopping waits.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/net/address.hpp"

namespace srd::firmware {

class HostLookup {
 public:
  using Resolve = std::function<Outcome<std::vector<Address>>(std::string_view text, std::string_view where)>;

  // Asks resolve (Address::parse_all, another in tests) for host until there is an address, with this pause in between; then
  // once more at every call of again.
  HostLookup(const std::string& host, const Resolve& resolve, std::chrono::milliseconds pause);
  HostLookup(const HostLookup&) = delete;
  HostLookup& operator=(const HostLookup&) = delete;
  // Does not wait: the thread ends by itself after the lookup that is under way.
  ~HostLookup();

  // --- any thread ---
  // Empty: none yet. As the last lookup that found any had them.
  [[nodiscard]] std::vector<Address> addresses() const;
  // The host does not answer: perhaps it has moved. Does not wait.
  void again();
  // Why there is no address yet; empty: there is one.
  [[nodiscard]] std::string problem() const;

 private:
  struct Answer;
  std::shared_ptr<Answer> answer_;  // with the thread, which may live longer
};

}  // namespace srd::firmware
