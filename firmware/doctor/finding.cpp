// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/finding.hpp"

#include <algorithm>

namespace srd::firmware {

std::string Finding::text() const {
  constexpr std::size_t kVerdictWidth = 6, kSubjectWidth = 13;
  std::string line = verdict == Verdict::kOk ? "OK" : verdict == Verdict::kWarn ? "WARN" : "FAIL";
  line.resize(kVerdictWidth, ' ');
  line += subject;
  line.resize(std::max(line.size() + 1, kVerdictWidth + kSubjectWidth), ' ');
  line += found + "\n";
  if (!advice.empty()) line += std::string(kVerdictWidth + kSubjectWidth, ' ') + "try: " + advice + "\n";
  return line;
}

void Diagnosis::ok(std::string subject, std::string found) { add({Verdict::kOk, std::move(subject), std::move(found)}); }

void Diagnosis::warn(std::string subject, std::string found, std::string advice) {
  add({Verdict::kWarn, std::move(subject), std::move(found), std::move(advice)});
}

void Diagnosis::fail(Exit exit, std::string subject, std::string found, std::string advice) {
  add({Verdict::kFail, std::move(subject), std::move(found), std::move(advice), exit});
}

void Diagnosis::fail(std::string subject, const Problem& problem) {
  std::string found = (problem.where.empty() ? "" : problem.where + ": ") + problem.what;
  if (!problem.expected.empty()) found += "; expected " + problem.expected;
  if (!problem.found.empty()) found += "; found " + problem.found;
  fail(problem.exit, std::move(subject), std::move(found), problem.advice);
}

Exit Diagnosis::exit() const {
  const auto failed = std::find_if(findings_.begin(), findings_.end(),
                                   [](const Finding& finding) { return finding.verdict == Verdict::kFail; });
  return failed == findings_.end() ? Exit::kDone : failed->exit;
}

void Diagnosis::add(Finding finding) {
  tell_(finding);
  findings_.push_back(std::move(finding));
}

}  // namespace srd::firmware
