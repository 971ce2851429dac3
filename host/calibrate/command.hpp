// SPDX-License-Identifier: Apache-2.0
// srd calibrate IMAGES.. | SETTINGS.xml --out DIR: a camera's lens, every number with its error.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// exit_code: an srd::Exit, set when the subcommand has run. app outlives the call; its callback reports to stdout and stderr.
void add_calibrate_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
