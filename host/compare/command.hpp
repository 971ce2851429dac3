// SPDX-License-Identifier: Apache-2.0
// `srd compare ESTIMATED.csv TRUTH.csv`: prints how far the estimated surfaces are from the true ones.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Adds the subcommand. When it runs, exit_code is set: 0; 3 also when the surface's rms exceeds --max-rms.
void add_compare_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
