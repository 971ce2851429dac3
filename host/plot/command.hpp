// SPDX-License-Identifier: Apache-2.0
// `srd plot FILE.csv`: PNG figures and one self-contained HTML page.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Adds the subcommand. When it runs, exit_code is set (DESIGN's codes).
void add_plot_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
