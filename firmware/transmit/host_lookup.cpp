// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/host_lookup.hpp"

#include <atomic>
#include <mutex>
#include <thread>

namespace srd::firmware {

struct HostLookup::Answer {
  std::atomic<bool> wanted{true};
  std::mutex mutex;  // of what follows
  std::vector<Address> addresses;
  std::string problem;
};

HostLookup::HostLookup(const std::string& host, const Resolve& resolve, std::chrono::milliseconds pause)
    : answer_(std::make_shared<Answer>()) {
  answer_->problem = "no answer yet to the lookup of '" + host + "'";
  std::thread([answer = answer_, host, resolve, pause] {
    while (answer->wanted) {
      auto found = resolve(host, {});
      {
        const std::lock_guard lock(answer->mutex);
        if (found) answer->addresses = *found;
        answer->problem = found ? "" : found.error().what;
      }
      if (found) return;
      std::this_thread::sleep_for(pause);
    }
  }).detach();
}

HostLookup::~HostLookup() { answer_->wanted = false; }

std::vector<Address> HostLookup::addresses() const {
  const std::lock_guard lock(answer_->mutex);
  return answer_->addresses;
}

std::string HostLookup::problem() const {
  const std::lock_guard lock(answer_->mutex);
  return answer_->problem;
}

}  // namespace srd::firmware
