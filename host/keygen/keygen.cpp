// SPDX-License-Identifier: Apache-2.0
#include "host/keygen/keygen.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "drivers/support/key_file.hpp"
#include "proto/identity.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

// What is to be written for one node.
Outcome<KeyFile> key_of(const std::string& node, const fs::path& file, const KeygenOptions& options) {
  if (!proto::NodeId::make(node))
    return Problem{
        Exit::kUsage, "not the name of a node", "NODE", "1 to 31 letters, digits, '-', '_' and '.'", "'" + node + "'", ""};
  std::error_code ignored;
  if (!options.change && !options.end_change) {
    if (fs::exists(fs::symlink_status(file, ignored)))
      return Problem{Exit::kUsage,
                     "the node has a key already",
                     file.string(),
                     "",
                     "",
                     "--change: a new key, and the node is heard with the one from before until --end-change"};
    return KeyFile{node, {SecretBytes::random()}};
  }
  auto key = KeyFile::read(file);
  if (!key) return key.error();
  if (key->node != node) return Problem{Exit::kUsage, "the key is another node's", file.string(), node, key->node, ""};
  key->keys.resize(1);
  if (options.change) key->keys.insert(key->keys.begin(), SecretBytes::random());
  return key;
}

}  // namespace

Outcome<std::string> keygen(const KeygenOptions& options) {
  std::vector<std::pair<fs::path, KeyFile>> files;
  for (const std::string& node : options.nodes) {
    const fs::path file = options.folder / (node + ".key");
    auto key = key_of(node, file, options);
    if (!key) return key.error();
    files.emplace_back(file, std::move(*key));
  }
  std::error_code ignored;
  if (!fs::is_directory(options.folder, ignored) && ::mkdir(options.folder.c_str(), 0700) != 0)
    return Problem{
        Exit::kInput, std::string("cannot make the folder: ") + std::strerror(errno), options.folder.string(), "", "", ""};
  std::string text;
  for (const auto& [file, key] : files) {
    if (const auto done = key.write(file); !done) return done.error();
    text += file.string() + ": " + (key.keys.size() > 1 ? "a new key, and the one from before" : "one key") + "\n";
  }
  return text;
}

}  // namespace srd::host
