// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/frame_store.hpp"

#include <algorithm>

namespace srd::firmware {

FrameStore::FrameStore(std::size_t frames, std::size_t bytes)
    : frames_(std::max<std::size_t>(frames, 1)),
      capacity_(bytes),
      slots_(std::make_unique<FrameSlot[]>(frames_)),
      ring_(new std::uint8_t[bytes]) {}  // not cleared: pages come as they are written

// A frame's bytes lie in one piece; the piece at the end that is too short for one stays unused.
std::size_t FrameStore::place(std::size_t bytes) const {
  if (next_ - oldest_ == frames_) return kNowhere;
  if (empty()) return bytes <= capacity_ ? 0 : kNowhere;
  const std::size_t tail = slots_[index(oldest_)].offset;
  if (head_ > tail) {
    if (capacity_ - head_ >= bytes) return head_;
    return tail >= bytes ? 0 : kNowhere;
  }
  return tail - head_ >= bytes ? head_ : kNowhere;
}

bool FrameStore::append(std::span<const std::uint8_t> encoded) {
  const std::size_t offset = place(encoded.size());
  if (offset == kNowhere || encoded.empty() || encoded.size() > 0xFFFF) return false;
  std::copy(encoded.begin(), encoded.end(), ring_.get() + offset);
  slot(next_) = FrameSlot{.offset = offset, .size = static_cast<std::uint16_t>(encoded.size())};
  head_ = offset + encoded.size();
  ++next_;
  return true;
}

void FrameStore::append_gap() {
  slot(next_) = FrameSlot{.offset = head_, .delivery = Delivery::kDone};
  ++next_;
}

std::uint64_t FrameStore::sequence_at(std::uint32_t slot_index) const {
  const std::uint32_t first = index(oldest_);
  const std::size_t ahead = slot_index >= first ? slot_index - first : slot_index + frames_ - first;
  return oldest_ + ahead;
}

std::span<const std::uint8_t> FrameStore::bytes(std::uint64_t sequence) const {
  const FrameSlot& slot = slots_[index(sequence)];
  return {ring_.get() + slot.offset, slot.size};
}

}  // namespace srd::firmware
