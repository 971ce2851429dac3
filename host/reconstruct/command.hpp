// SPDX-License-Identifier: Apache-2.0
// srd reconstruct SETTINGS.xml | RECORDING --out DIR: surfaces from an OpenSRD folder or a recording, offline.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// exit_code: an srd::Exit, set when the subcommand has run. app outlives the call; its callback reports to stdout and stderr.
void add_reconstruct_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
