// SPDX-License-Identifier: Apache-2.0
// A ring between one thread that puts in and one that takes out. Fixed capacity, no locks, no heap after construction.
// What does not fit is counted, not waited for.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace srd {

// T is default constructible; slots are assigned over and over.
template <class T>
class SpscRing {
 public:
  explicit SpscRing(std::size_t capacity) : slots_(std::make_unique<T[]>(capacity + 1)), slot_count_(capacity + 1) {}

  // --- the putting thread ---
  // The slot to fill, then push(); nullptr when full: the caller drops its item, which counts as overflow, or waits.
  [[nodiscard]] T* back() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (next(tail) == head_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[tail];
  }
  void push() { tail_.store(next(tail_.load(std::memory_order_relaxed)), std::memory_order_release); }
  // False, and counted, when full.
  bool try_push(const T& item) {
    T* slot = back();
    if (slot == nullptr) {
      overflow_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    *slot = item;
    push();
    return true;
  }

  // --- the taking thread ---
  // The oldest item, valid until pop(); nullptr when empty.
  [[nodiscard]] T* front() {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &slots_[head];
  }
  void pop() { head_.store(next(head_.load(std::memory_order_relaxed)), std::memory_order_release); }

  // --- any thread ---
  [[nodiscard]] std::uint64_t overflow() const { return overflow_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool empty() const { return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_acquire); }
  [[nodiscard]] std::size_t capacity() const { return slot_count_ - 1; }

 private:
  [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 == slot_count_ ? 0 : i + 1; }

  std::unique_ptr<T[]> slots_;
  std::size_t slot_count_;
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
  alignas(64) std::atomic<std::uint64_t> overflow_{0};
};

}  // namespace srd
