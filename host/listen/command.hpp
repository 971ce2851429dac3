// SPDX-License-Identifier: Apache-2.0
// The subcommand `srd listen`.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Adds the subcommand with its callback, which runs it and puts an exit code into exit_code.
void add_listen_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
