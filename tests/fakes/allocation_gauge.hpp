// SPDX-License-Identifier: Apache-2.0
// Counts what a thread takes from the heap: arm, run, read. The definitions are in allocation_gauge.cpp, which replaces
// malloc and its kin for the whole program; under a sanitizer, which has its own, works() is false.
#pragma once

#include <cstdint>

namespace srd::fakes {

class AllocationGauge {
 public:
  AllocationGauge();  // counts from here, on this thread
  ~AllocationGauge();
  AllocationGauge(const AllocationGauge&) = delete;
  AllocationGauge& operator=(const AllocationGauge&) = delete;
  [[nodiscard]] std::int64_t count() const;
  [[nodiscard]] static bool works();  // false under a sanitizer
};

}  // namespace srd::fakes
