// SPDX-License-Identifier: Apache-2.0
#include "host/keygen/command.hpp"

#include <cstdio>
#include <memory>

#include "host/keygen/keygen.hpp"

namespace srd::host {

void add_keygen_command(CLI::App& app, int& exit_code) {
  auto given = std::make_shared<KeygenOptions>();
  CLI::App* command = app.add_subcommand("keygen", "Make a node's key, change it, or end the change");
  command->add_option("node", given->nodes, "The nodes, as node.id names them")->required();
  command->add_option("--out", given->folder, "Folder of keys, as srd listen --keys takes it: DIR/NODE.key")->required();
  auto* change = command->add_flag("--change", given->change, "A new key; the one from before goes on to be accepted");
  auto* end = command->add_flag("--end-change", given->end_change, "Forget the key from before");
  change->excludes(end);
  command->footer(
      "DIR/NODE.key goes to the node as /etc/flume-srd/node.key, over a way that nobody listens to, and there belongs to the\n"
      "service alone: install -o flume-srd -g flume-srd -m 400 NODE.key /etc/flume-srd/node.key\n"
      "Changing a key: --change here, the new file to the node, restart the node, then --end-change here. srd listen goes on.");
  command->callback([given, &exit_code] {
    const auto done = keygen(*given);
    if (done.ok()) {
      std::fputs(done->c_str(), stdout);
      exit_code = static_cast<int>(Exit::kDone);
    } else {
      std::fputs(done.error().text().c_str(), stderr);
      exit_code = static_cast<int>(done.error().exit);
    }
  });
}

}  // namespace srd::host
