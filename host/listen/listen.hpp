// SPDX-License-Identifier: Apache-2.0
// srd listen: a socket, a session, a terminal.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/net/udp_socket.hpp"
#include "host/fusion/fusion.hpp"
#include "host/listen/coefficient_file.hpp"
#include "host/listen/session.hpp"

namespace srd::host {

struct ListenOptions {
  std::string bind = "127.0.0.1:47810";
  std::filesystem::path csv{};  // empty: no file; frames are acknowledged and only shown
  OpenMode open = OpenMode::kNew;
  std::filesystem::path record{};                    // folder of MCAP segments, which are gone on with; empty: none
  std::filesystem::path keys{};                      // folder of nodes' keys; empty: a link without keys
  std::uint64_t count = 0;                           // rows after which to end; 0: no end
  double seconds = 0;                                // after which to end; 0: no end
  std::optional<FusionOptions> fuse{};               // boards whose surfaces become one; its sinks and boot are set here
  std::vector<FrameSink*> further_sinks{};           // get every frame too; outlive the call
  std::function<void(const std::string&)> notify{};  // a line for a person (warnings, summary): stderr
  std::function<void(const std::string&)> show{};    // the line that is rewritten; none: no terminal
  std::function<void(const Address&)> listening{};   // told once the socket is open
};

// Runs until count, seconds or stop; then waits up to a second for gaps that live nodes still fill, flushes and acknowledges.
// kUsage (address, existing file, keys), kInput (file to append to), kDevice (cannot write), kNetwork (cannot bind).
[[nodiscard]] Outcome<void> listen(const ListenOptions& options, const std::atomic<bool>& stop);

}  // namespace srd::host
