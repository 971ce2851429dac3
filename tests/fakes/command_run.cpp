// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/command_run.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace srd::fakes {

CommandRun run_command(void (*add)(CLI::App&, int&), std::vector<std::string> words) {
  CLI::App app;
  CommandRun run;
  app.require_subcommand(1);
  add(app, run.exit);
  std::reverse(words.begin(), words.end());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    run.exit = 2;
    std::cerr << error.what();
  }
  run.out = testing::internal::GetCapturedStdout();
  run.err = testing::internal::GetCapturedStderr();
  return run;
}

}  // namespace srd::fakes
