// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/recording_section.hpp"

namespace srd::firmware {

RecordingSection read_recording_section(TomlTable table, const std::filesystem::path& folder) {
  RecordingSection section;
  if (auto given = table.text("folder")) {
    if (given->empty())
      table.complain("folder", "a folder", "\"\"", "leave the key out to record nothing");
    else
      section.folder = folder / *given;
  }
  if (auto frames = table.integer("queue_frames", {2, 10000, "frames"}))
    section.queue_frames = static_cast<std::size_t>(*frames);
  if (auto sync = table.integer("sync_ms", {10, 60000, "ms"})) section.sync_ms = *sync;
  if (auto free = table.integer("min_free_mib", {0, 1e9, "MiB"})) section.min_free_mib = static_cast<std::uint64_t>(*free);
  return section;
}

}  // namespace srd::firmware
