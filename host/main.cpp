// SPDX-License-Identifier: Apache-2.0
// srd: the host's program. Each subcommand has its folder.
#include <CLI/CLI.hpp>
#include <iostream>

#include "drivers/support/problem.hpp"
#include "host/calibrate/command.hpp"
#include "host/compare/command.hpp"
#include "host/keygen/command.hpp"
#include "host/listen/command.hpp"
#include "host/plot/command.hpp"
#include "host/pose/command.hpp"
#include "host/reconstruct/command.hpp"
#include "host/rig_check/command.hpp"
#include "host/simulate/command.hpp"
#include "host/study/command.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Flume SRD, host side: calibrates, receives, reconstructs, simulates, compares and plots water surfaces."};
  app.set_version_flag("--version", SRD_VERSION);
  app.require_subcommand(1);
  int exit_code = 0;
  srd::host::add_calibrate_command(app, exit_code);
  srd::host::add_keygen_command(app, exit_code);
  srd::host::add_listen_command(app, exit_code);
  srd::host::add_reconstruct_command(app, exit_code);
  srd::host::add_simulate_command(app, exit_code);
  srd::host::add_compare_command(app, exit_code);
  srd::host::add_plot_command(app, exit_code);
  srd::host::add_pose_command(app, exit_code);
  srd::host::add_rig_check_command(app, exit_code);
  srd::host::add_study_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RequiredError& error) {
    if (!app.get_subcommands().empty() || app.remaining().empty()) {
      app.exit(error);
    } else {
      const srd::Problem problem{srd::Exit::kUsage,
                                 "unknown subcommand '" + app.remaining().front() + "'",
                                 "srd",
                                 "calibrate, keygen, listen, reconstruct, simulate, compare, plot, pose, rig-check or study",
                                 "",
                                 "srd --help"};
      std::cerr << problem.text();
    }
    return static_cast<int>(srd::Exit::kUsage);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_code : static_cast<int>(srd::Exit::kUsage);
  }
  return exit_code;
}
