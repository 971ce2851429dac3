// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/host_lookup.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace srd::firmware {

struct HostLookup::Answer {
  std::atomic<bool> wanted{true};
  std::mutex mutex;  // of what follows
  std::condition_variable wake;
  bool again = false;
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
        // A name that had an address keeps it while the network is away.
        if (found || answer->addresses.empty()) answer->problem = found ? "" : found.error().what;
      }
      std::unique_lock lock(answer->mutex);
      const auto asked = [&] { return answer->again || !answer->wanted; };
      if (found)
        answer->wake.wait(lock, asked);
      else
        answer->wake.wait_for(lock, pause, [&] { return !answer->wanted; });
      answer->again = false;
    }
  }).detach();
}

HostLookup::~HostLookup() {
  {
    const std::lock_guard lock(answer_->mutex);
    answer_->wanted = false;
  }
  answer_->wake.notify_one();
}

void HostLookup::again() {
  {
    const std::lock_guard lock(answer_->mutex);
    answer_->again = true;
  }
  answer_->wake.notify_one();
}

std::vector<Address> HostLookup::addresses() const {
  const std::lock_guard lock(answer_->mutex);
  return answer_->addresses;
}

std::string HostLookup::problem() const {
  const std::lock_guard lock(answer_->mutex);
  return answer_->problem;
}

}  // namespace srd::firmware
