// SPDX-License-Identifier: Apache-2.0
// The encoded frames that the host does not have yet, oldest first, in a ring of bytes that is reserved once.
// One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace srd::firmware {

// Where a kept frame is on its way.
enum class Delivery : std::uint8_t {
  kUnsent,
  kInFlight,  // sent, no answer yet
  kOverdue,   // sent, and to be sent again
  kReceived,  // the host has it, not yet in its record
  kDone,      // in the host's record: the slot is free once all older ones are
};

struct FrameSlot {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::int64_t sent_ns = 0;                     // last time
  std::size_t offset = 0;                       // in the byte ring
  std::uint32_t before = kNone, after = kNone;  // neighbours in the sender's list, as slot numbers
  std::uint16_t size = 0;                       // bytes
  Delivery delivery = Delivery::kUnsent;
  bool resent = false;
};

class FrameStore {
 public:
  // At most so many frames and bytes; memory is touched only as it fills. frames < 2^32 - 1.
  FrameStore(std::size_t frames, std::size_t bytes);

  // Numbers of the kept frames: oldest(), .., next() - 1.
  [[nodiscard]] std::uint64_t oldest() const { return oldest_; }
  [[nodiscard]] std::uint64_t next() const { return next_; }
  [[nodiscard]] bool empty() const { return oldest_ == next_; }
  [[nodiscard]] bool holds(std::uint64_t sequence) const { return sequence >= oldest_ && sequence < next_; }
  [[nodiscard]] std::size_t frames() const { return frames_; }

  // Whether a frame of so many bytes can be appended without dropping one.
  [[nodiscard]] bool fits(std::size_t bytes) const { return place(bytes) != kNowhere; }
  // False when it does not fit. Its number is the next() from before.
  bool append(std::span<const std::uint8_t> encoded);
  // A number without a frame: it is kDone.
  void append_gap();
  // The number of the first frame of an empty store.
  void begin_at(std::uint64_t sequence) { oldest_ = next_ = sequence; }
  // The store is not empty.
  void drop_oldest() { ++oldest_; }

  [[nodiscard]] std::uint32_t index(std::uint64_t sequence) const { return static_cast<std::uint32_t>(sequence % frames_); }
  [[nodiscard]] FrameSlot& slot(std::uint64_t sequence) { return slots_[index(sequence)]; }
  [[nodiscard]] FrameSlot& at(std::uint32_t slot_index) { return slots_[slot_index]; }
  // The number of the frame in a slot that is in use.
  [[nodiscard]] std::uint64_t sequence_at(std::uint32_t slot_index) const;
  [[nodiscard]] std::span<const std::uint8_t> bytes(std::uint64_t sequence) const;

 private:
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  [[nodiscard]] std::size_t place(std::size_t bytes) const;

  std::size_t frames_;
  std::size_t capacity_;
  std::unique_ptr<FrameSlot[]> slots_;
  std::unique_ptr<std::uint8_t[]> ring_;
  std::size_t head_ = 0;  // one past the newest frame's bytes
  std::uint64_t oldest_ = 0, next_ = 0;
};

}  // namespace srd::firmware
