// SPDX-License-Identifier: Apache-2.0
// What a check of the doctor came to, and what to do about it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd::firmware {

enum class Verdict : std::uint8_t { kOk, kWarn, kFail };

struct Finding {
  Verdict verdict = Verdict::kOk;
  std::string subject;        // "camera"
  std::string found;          // one line
  std::string advice{};       // what to do, not with kOk
  Exit exit = Exit::kDevice;  // of the program, with kFail

  // "WARN  clock      does not follow a reference" and a line "                 try: ..".
  [[nodiscard]] std::string text() const;
};

// Findings in the order in which they come; each is told at once.
class Diagnosis {
 public:
  explicit Diagnosis(std::function<void(const Finding&)> tell = [](const Finding&) {}) : tell_(std::move(tell)) {}

  void ok(std::string subject, std::string found);
  void warn(std::string subject, std::string found, std::string advice);
  void fail(Exit exit, std::string subject, std::string found, std::string advice);
  void fail(std::string subject, const Problem& problem);

  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }
  // Of the first that failed; kDone when none did.
  [[nodiscard]] Exit exit() const;

 private:
  void add(Finding finding);
  std::function<void(const Finding&)> tell_;
  std::vector<Finding> findings_;
};

}  // namespace srd::firmware
