// SPDX-License-Identifier: Apache-2.0
// The service manager's end of sd_notify.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "drivers/support/unique_fd.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::fakes {

class NotifySocket {
 public:
  explicit NotifySocket(long watchdog_us = 0) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (scratch_.path() / "notify").string();
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    socket_ = UniqueFd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    if (watchdog_us > 0) ::setenv("WATCHDOG_USEC", std::to_string(watchdog_us).c_str(), 1);
  }
  ~NotifySocket() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  // All that was said so far.
  std::vector<std::string> said() {
    std::array<char, 1024> text;
    for (ssize_t size; (size = ::recv(socket_.get(), text.data(), text.size(), 0)) > 0;)
      said_.emplace_back(text.data(), static_cast<std::size_t>(size));
    return said_;
  }

 private:
  ScratchFolder scratch_;
  UniqueFd socket_;
  std::vector<std::string> said_;
};

}  // namespace srd::fakes
