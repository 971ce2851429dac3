// SPDX-License-Identifier: Apache-2.0
// The command line of srd keygen.
#pragma once

#include <CLI/CLI.hpp>

namespace srd::host {

void add_keygen_command(CLI::App& app, int& exit_code);

}  // namespace srd::host
