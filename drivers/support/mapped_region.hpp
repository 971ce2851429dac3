// SPDX-License-Identifier: Apache-2.0
// Owns one memory mapping and undoes it.
#pragma once

#include <sys/mman.h>
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace srd {

class MappedRegion {
 public:
  MappedRegion() = default;
  // Shares fd's bytes [offset, offset + length); not valid(), with errno, when the system refuses. offset: of a page.
  [[nodiscard]] static MappedRegion of_file(int fd, std::size_t length, std::int64_t offset, int protection) noexcept {
    return MappedRegion(::mmap(nullptr, length, protection, MAP_SHARED, fd, static_cast<off_t>(offset)), length);
  }
  // Zeroed memory of the process itself.
  [[nodiscard]] static MappedRegion anonymous(std::size_t length) noexcept {
    return MappedRegion(::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0), length);
  }
  MappedRegion(MappedRegion&& other) noexcept
      : address_(std::exchange(other.address_, nullptr)), length_(std::exchange(other.length_, 0)) {}
  MappedRegion& operator=(MappedRegion&& other) noexcept {
    if (this != &other) {
      reset();
      address_ = std::exchange(other.address_, nullptr);
      length_ = std::exchange(other.length_, 0);
    }
    return *this;
  }
  ~MappedRegion() { reset(); }

  [[nodiscard]] std::uint8_t* data() const noexcept { return static_cast<std::uint8_t*>(address_); }
  [[nodiscard]] std::size_t size() const noexcept { return length_; }  // bytes
  [[nodiscard]] bool valid() const noexcept { return address_ != nullptr; }
  void reset() noexcept {
    if (address_ != nullptr) ::munmap(address_, length_);
    address_ = nullptr;
    length_ = 0;
  }

 private:
  MappedRegion(void* address, std::size_t length) noexcept
      : address_(address == MAP_FAILED ? nullptr : address), length_(address == MAP_FAILED ? 0 : length) {}

  void* address_ = nullptr;
  std::size_t length_ = 0;
};

}  // namespace srd
