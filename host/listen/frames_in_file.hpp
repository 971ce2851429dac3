// SPDX-License-Identifier: Apache-2.0
// Which frames a coefficient file has, read line by line: a long run's file is larger than memory.
#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"
#include "host/listen/sequence_set.hpp"

namespace srd::host {

struct FramesInFile {
  std::optional<dsp::ModeList> modes;  // of the header; none: the file is empty or was cut within its header
  std::map<proto::BootId, SequenceSet> frames;
  std::uint64_t rows = 0;
  std::uintmax_t whole_bytes = 0;  // up to the end of the last whole line
};

// kInput with file:line when the file is no coefficient file of srd listen.
[[nodiscard]] Outcome<FramesInFile> read_frames_in_file(const std::filesystem::path& file);

}  // namespace srd::host
