// SPDX-License-Identifier: Apache-2.0
// [record]: the camera's frames kept on disk while the node measures.
#pragma once

#include <cstdint>
#include <filesystem>

#include "drivers/support/toml_reader.hpp"

namespace srd::firmware {

struct RecordingSection {
  std::filesystem::path folder;  // empty: nothing is recorded
  // The file names where recordings go: a folder that holds one is passed over for FOLDER-2, FOLDER-3, .. , and a disk that
  // takes none does not stop the measurement. The command line names the folder itself.
  bool numbered_folders = true;
  bool force = false;             // replace a recording that is there
  std::size_t queue_frames = 64;  // between the frame loop and the disk, each as large as an image
  std::int64_t sync_ms = 1000;    // what a power cut can take
  std::uint64_t min_free_mib = 512;
};

// folder: that relative paths start from.
[[nodiscard]] RecordingSection read_recording_section(TomlTable table, const std::filesystem::path& folder);

}  // namespace srd::firmware
