// A recording that survives a power cut: frames.csv lists only frames whose image is on the disk. Images (PGM) are written
// one by one; sync() brings them to the disk together, then their rows. Cut at any moment, the folder is a recording of
// all frames up to the last sync. One thread; add and sync do not throw.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "drivers/recording/recording.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd {

class DurableRecording {
 public:
  // Makes the folder and an empty frames.csv. kUsage when it holds a recording and overwrite is false. With overwrite the
  // old list is emptied on the disk first, and truth.csv and reference.png, which would be of other frames, go.
  [[nodiscard]] static Outcome<DurableRecording> create(const std::filesystem::path& folder, bool overwrite);

  // pixels: width * height, row by row without gaps. frame.file is ignored: images are frame_000000.pgm, .. .
  // 0, or the errno of what did not work; nothing of the frame is left then.
  [[nodiscard]] int add(std::span<const std::uint8_t> pixels, int width, int height, const RecordedFrame& frame) noexcept;
  // 0, or an errno: the rows since the last sync are then not in the list.
  [[nodiscard]] int sync() noexcept;

  [[nodiscard]] std::uint64_t listed() const { return listed_; }
  // Bytes that are free where the recording lies, for an ordinary user.
  [[nodiscard]] std::uint64_t free_bytes() const noexcept;
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  UniqueFd directory_, listing_;
  std::string rows_;  // of images that are not on the disk yet
  std::uint64_t written_ = 0, listed_ = 0;
  std::int64_t listing_bytes_ = 0;
};

}  // namespace srd
