// SPDX-License-Identifier: Apache-2.0
// Which triggers the camera answered with a frame. One thread; no heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace srd {

class TriggerWatch {
 public:
  // tolerance: of a stamp about the one that its trigger promises; below half a period.
  explicit TriggerWatch(std::int64_t tolerance_ns) : tolerance_ns_(tolerance_ns) {}

  void triggered(std::int64_t expected_stamp_ns) {
    if (count_ == expected_.size()) lose();
    expected_[(first_ + count_++) % expected_.size()] = expected_stamp_ns;
  }
  // Stamps ascend. Returns whether a trigger made this frame.
  bool stamped(std::int64_t stamp_ns) {
    while (count_ > 0 && expected_[first_] + tolerance_ns_ < stamp_ns) lose();
    if (count_ == 0 || expected_[first_] - tolerance_ns_ > stamp_ns) {
      ++untriggered_;
      return false;
    }
    drop();
    return true;
  }
  [[nodiscard]] std::uint64_t missed() const { return missed_; }            // triggers without a frame
  [[nodiscard]] std::uint64_t untriggered() const { return untriggered_; }  // frames without a trigger

 private:
  void drop() {
    first_ = (first_ + 1) % expected_.size();
    --count_;
  }
  void lose() {
    ++missed_;
    drop();
  }
  std::int64_t tolerance_ns_;
  std::array<std::int64_t, 64> expected_{};  // more than a camera can be behind
  std::size_t first_ = 0, count_ = 0;
  std::uint64_t missed_ = 0, untriggered_ = 0;
};

}  // namespace srd
