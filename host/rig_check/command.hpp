// SPDX-License-Identifier: Apache-2.0
// srd rig-check: has the camera or the pattern moved since the reference image?
#pragma once

namespace CLI {
class App;
}

namespace srd::host {

// Beside those of every program (drivers/support/problem.hpp).
inline constexpr int kMovedExit = 6;

void add_rig_check_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
