// SPDX-License-Identifier: Apache-2.0
// `srd study --out DIR`: how precise corners and surfaces are, as tables, figures and one page.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Adds the subcommand. When it runs, exit_code is set (DESIGN's codes).
void add_study_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
