// SPDX-License-Identifier: Apache-2.0
// `srd simulate SCENE.toml --out DIR`: renders a recording with known truth.
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Adds the subcommand. When it runs, exit_code is set.
void add_simulate_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
