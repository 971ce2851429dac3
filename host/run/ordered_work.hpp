// SPDX-License-Identifier: Apache-2.0
// Work on items 0, 1, 2, .. by several threads, its results taken in order by one. What an item gives must depend on
// nothing but its number: then the number of threads changes nothing but the time.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace srd::host {

// As many as the machine runs at once.
[[nodiscard]] inline int hardware_threads() {
  const unsigned n = std::thread::hardware_concurrency();
  return n == 0 ? 1 : static_cast<int>(n);
}

template <class T>
class OrderedWork {
 public:
  // work(item, thread): called by thread 0..threads - 1, never by two for the same number at once; must not throw.
  // threads <= 1: by the taker's own thread. At most ahead results wait to be taken, so memory stays bounded.
  OrderedWork(int threads, std::size_t items, std::size_t ahead, std::function<T(std::size_t, int)> work)
      : work_(std::move(work)), items_(items), ahead_(std::max<std::size_t>(ahead, 1)), done_(ahead_) {
    if (threads <= 1) return;
    for (int thread = 0; thread < threads; ++thread)
      threads_.emplace_back([this, thread](const std::stop_token& stop) { serve(stop, thread); });
  }
  ~OrderedWork() {
    for (std::jthread& thread : threads_) thread.request_stop();
    changed_.notify_all();
  }
  OrderedWork(const OrderedWork&) = delete;
  OrderedWork& operator=(const OrderedWork&) = delete;

  // The next item's result, the first time item 0's. At most once an item.
  [[nodiscard]] T take() {
    if (threads_.empty()) return work_(taken_++, 0);
    std::unique_lock lock(mutex_);
    std::optional<T>& slot = done_[taken_ % ahead_];
    changed_.wait(lock, [&] { return slot.has_value(); });
    T result = std::move(*slot);
    slot.reset();
    ++taken_;
    changed_.notify_all();
    return result;
  }

 private:
  void serve(const std::stop_token& stop, int thread) {
    for (;;) {
      std::size_t item = 0;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, stop, [&] { return next_ >= items_ || next_ < taken_ + ahead_; });
        if (stop.stop_requested() || next_ >= items_) return;
        item = next_++;
      }
      T result = work_(item, thread);
      const std::scoped_lock lock(mutex_);
      done_[item % ahead_] = std::move(result);
      changed_.notify_all();
    }
  }

  std::function<T(std::size_t, int)> work_;
  std::size_t items_, ahead_, next_ = 0, taken_ = 0;
  std::vector<std::optional<T>> done_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::jthread> threads_;  // last: they end before what they use
};

}  // namespace srd::host
