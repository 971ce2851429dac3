// SPDX-License-Identifier: Apache-2.0
#include "host/listen/key_folder.hpp"

#include <algorithm>

#include "drivers/support/key_file.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

Problem keygen_makes_one(const fs::path& folder, const char* what) {
  return {Exit::kUsage,
          what,
          folder.string(),
          "a folder with a file NODE.key for each node",
          "",
          "srd keygen NODE --out " + folder.string()};
}

}  // namespace

std::vector<Problem> KeyFolder::read() {
  std::vector<Problem> problems;
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error))
    if (entry.path().extension() == ".key") files.push_back(entry.path());
  if (error) {
    problems.push_back(keygen_makes_one(folder_, "cannot read the folder of keys"));
    return problems;
  }
  std::sort(files.begin(), files.end());
  // A file that is gone: its node has no key any more.
  std::erase_if(keys_, [&](const auto& known) {
    return std::none_of(files.begin(), files.end(), [&](const fs::path& file) { return file.stem() == known.first.view(); });
  });
  for (const fs::path& file : files) {
    const auto read = KeyFile::read(file);
    if (!read) {
      problems.push_back(read.error());
      continue;
    }
    const auto node = proto::NodeId::make(read->node);
    if (!node || file.stem() != read->node) {
      problems.push_back({Exit::kUsage, "the key is another node's than its file's name says", file.string(),
                          read->node + ".key", file.filename().string(), "name the file after the node that is in it"});
      continue;
    }
    std::vector<proto::Key>& keys = keys_[*node];
    keys.clear();
    for (const SecretBytes& key : read->keys) keys.emplace_back(key.bytes());
  }
  return problems;
}

Outcome<KeyFolder> KeyFolder::open(const fs::path& folder) {
  KeyFolder made;
  made.folder_ = folder;
  if (const auto problems = made.read(); !problems.empty()) return problems.front();
  if (made.keys_.empty()) return keygen_makes_one(folder, "no key in the folder");
  return made;
}

std::vector<proto::Key> KeyFolder::keys_of(const proto::NodeId& node, std::int64_t now,
                                           const std::function<void(const std::string&)>& notify) {
  if (now - read_ns_ >= kReadAgain) {
    read_ns_ = now;
    std::string problems;
    for (const Problem& problem : read()) problems += problem.text();
    if (problems != told_ && !problems.empty() && notify) notify(problems);
    told_ = problems;
  }
  const auto found = keys_.find(node);
  return found == keys_.end() ? std::vector<proto::Key>{} : found->second;
}

}  // namespace srd::host
