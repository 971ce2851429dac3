// SPDX-License-Identifier: Apache-2.0
// The system's own port, on a pipe in place of a device.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/support/unique_fd.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using std::chrono::nanoseconds;

// A camera that is slow to start leaves no time of the call that started it: silent is not gone.
TEST(V4l2Port, WithoutTimeLeftItLooksAndNoMore) {
  const fakes::ScratchFolder scratch;
  const std::filesystem::path pipe = scratch.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto port = system_v4l2_port();
  ASSERT_EQ(port->open(pipe.c_str()), 0);
  for (const nanoseconds none : {nanoseconds(0), nanoseconds(-1), nanoseconds(-5'000'000'000)})
    EXPECT_EQ(port->wait(none), V4l2Port::Ready::kTimeout);
  const UniqueFd writer(::open(pipe.c_str(), O_WRONLY | O_CLOEXEC));
  ASSERT_EQ(::write(writer.get(), "x", 1), 1);
  for (const nanoseconds none : {nanoseconds(0), nanoseconds(-5'000'000'000)})
    EXPECT_EQ(port->wait(none), V4l2Port::Ready::kFrame);
}

}  // namespace
}  // namespace srd
