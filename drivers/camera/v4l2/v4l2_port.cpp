// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_port.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

#include "drivers/support/system_clock.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// None left counts as none: poll refuses a negative time, and looks even without any.
timespec bounded(std::int64_t ns) { return timespec_of(std::clamp<std::int64_t>(ns, 0, 1000 * kSecond)); }

class SystemPort final : public V4l2Port {
 public:
  int open(const char* path) noexcept override {
    close();
    // Non-blocking: taking a buffer never waits, poll does, with its deadline.
    fd_.reset(::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC));
    return fd_.valid() ? 0 : errno;
  }
  void close() noexcept override { fd_.reset(); }
  int control(unsigned long request, void* argument) noexcept override {
    while (::ioctl(fd_.get(), request, argument) != 0)
      if (errno != EINTR) return errno;
    return 0;
  }
  MappedRegion map(std::size_t length, std::int64_t offset) noexcept override {
    return MappedRegion::of_file(fd_.get(), length, offset, PROT_READ | PROT_WRITE);
  }
  Ready wait(std::chrono::nanoseconds timeout) noexcept override {
    const std::int64_t deadline = now_ns() + timeout.count();
    for (;;) {
      pollfd asked{fd_.get(), POLLIN, 0};
      const timespec left = bounded(deadline - now_ns());
      const int n = ::ppoll(&asked, 1, &left, nullptr);
      if (n == 0) return Ready::kTimeout;
      if (n < 0) {
        if (errno == EINTR) continue;
        return Ready::kError;
      }
      return (asked.revents & POLLIN) != 0 ? Ready::kFrame : Ready::kError;
    }
  }
  std::int64_t now_ns() noexcept override { return clock_ns(CLOCK_MONOTONIC); }
  void pause(std::chrono::nanoseconds time) noexcept override {
    const timespec wanted = bounded(time.count());
    clock_nanosleep(CLOCK_MONOTONIC, 0, &wanted, nullptr);
  }

 private:
  UniqueFd fd_;
};

}  // namespace

std::unique_ptr<V4l2Port> system_v4l2_port() { return std::make_unique<SystemPort>(); }

}  // namespace srd
