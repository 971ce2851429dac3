// Counts what the heap gives out while it is armed. Include in one source file of an executable only.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SRD_SANITIZER_OWNS_MALLOC
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SRD_SANITIZER_OWNS_MALLOC
#endif
#endif
#ifdef SRD_SANITIZER_OWNS_MALLOC
#include <sanitizer/allocator_interface.h>
#endif

namespace srd::fakes {

inline std::atomic<bool> allocation_counter_armed{false};
inline std::atomic<long> allocation_count{0};

inline void count_allocation() {
  if (allocation_counter_armed.load(std::memory_order_relaxed)) ++allocation_count;
}

#ifdef SRD_SANITIZER_OWNS_MALLOC
namespace detail {
inline void on_malloc(const volatile void*, std::size_t) { count_allocation(); }
inline void on_free(const volatile void*) {}
inline const int installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
}  // namespace detail
#endif

// Armed from construction; counts malloc, calloc, realloc, aligned forms and operator new of all threads.
class AllocationCounter {
 public:
  AllocationCounter() {
    allocation_count = 0;
    allocation_counter_armed = true;
  }
  ~AllocationCounter() { allocation_counter_armed = false; }
  AllocationCounter(const AllocationCounter&) = delete;
  AllocationCounter& operator=(const AllocationCounter&) = delete;
  [[nodiscard]] long count() const { return allocation_count; }
};

}  // namespace srd::fakes

#ifndef SRD_SANITIZER_OWNS_MALLOC
// glibc's own names for the functions that these replace; its operator new and aligned_alloc end here too.
extern "C" {
void* __libc_malloc(std::size_t);                   // NOLINT
void* __libc_calloc(std::size_t, std::size_t);      // NOLINT
void* __libc_realloc(void*, std::size_t);           // NOLINT
void* __libc_memalign(std::size_t, std::size_t);    // NOLINT

void* malloc(std::size_t size) noexcept {
  srd::fakes::count_allocation();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  srd::fakes::count_allocation();
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) noexcept {
  srd::fakes::count_allocation();
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  srd::fakes::count_allocation();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return memalign(alignment, size); }
int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  *out = memalign(alignment, size);
  return *out == nullptr ? 12 : 0;  // ENOMEM
}
}
#endif
