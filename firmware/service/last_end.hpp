// SPDX-License-Identifier: Apache-2.0
// How the node ended last time, kept over restarts in a small file: written as "killed" while the node runs, replaced by the
// reason when there is one, removed by a clean stop. What is there at the start is the last end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/support/problem.hpp"

namespace srd::firmware {

class LastEnd {
 public:
  static constexpr std::size_t kMaxText = 95;  // bytes; what a status has room for

  // STATE_DIRECTORY as systemd gives it (the first of several), empty without.
  [[nodiscard]] static std::filesystem::path service_folder();

  // Remembers nothing.
  LastEnd() = default;
  // Reads the last end and marks the node as running. kInput when the folder cannot be written.
  [[nodiscard]] static Outcome<LastEnd> open(const std::filesystem::path& folder);

  // Of the run before this one; empty after a clean stop.
  [[nodiscard]] const std::string& text() const { return text_; }
  // Starts in a row that followed an abnormal end; 0: the first one.
  [[nodiscard]] std::uint32_t restarts() const { return restarts_; }

  // This run ends abnormally: the reason, cut to kMaxText, control characters as spaces.
  void write(std::string_view reason) const;
  // This run ends as it should.
  void clear() const;
  // From here on SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT leave their name before they end the process. One LastEnd of
  // the process; it need not outlive the call.
  void catch_fatal_signals() const;
  // From a signal handler, after catch_fatal_signals: a person ended the node at once.
  static void clear_from_signal();

 private:
  std::filesystem::path file_;  // empty: nothing is kept
  std::string text_;
  std::uint32_t restarts_ = 0;
};

}  // namespace srd::firmware
