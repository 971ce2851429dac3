// SPDX-License-Identifier: Apache-2.0
// A subcommand of srd, run inside the test. CLI11 is compiled here alone: it costs 7 s wherever it is included.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace srd::fakes {

struct CommandRun {
  int exit = -1;
  std::string out, err;
};

// words: of the command line, without the program's name. What CLI11 refuses gives 2 and its message on err.
[[nodiscard]] CommandRun run_command(void (*add)(CLI::App&, int&), std::vector<std::string> words);

}  // namespace srd::fakes
