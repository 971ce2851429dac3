// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/allocation_gauge.hpp"

#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SRD_OWN_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SRD_OWN_MALLOC 0
#else
#define SRD_OWN_MALLOC 1
#endif
#else
#define SRD_OWN_MALLOC 1
#endif

namespace {

thread_local bool armed = false;
thread_local std::int64_t taken = 0;

}  // namespace

#if SRD_OWN_MALLOC
// glibc's own entry points, so that C libraries are counted too.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t bytes) {
  if (armed) ++taken;
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
  if (armed) ++taken;
  return __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) {
  if (armed) ++taken;
  return __libc_realloc(old, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  if (armed) ++taken;
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) {
  if (armed) ++taken;
  *out = __libc_memalign(alignment, bytes);
  return *out == nullptr ? 12 : 0;
}
}
#endif

namespace srd::fakes {

AllocationGauge::AllocationGauge() {
  taken = 0;
  armed = true;
}
AllocationGauge::~AllocationGauge() { armed = false; }
std::int64_t AllocationGauge::count() const { return taken; }
bool AllocationGauge::works() { return SRD_OWN_MALLOC != 0; }

}  // namespace srd::fakes
