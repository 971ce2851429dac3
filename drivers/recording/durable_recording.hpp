// SPDX-License-Identifier: Apache-2.0
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
  // barrier: brings a file system to its disk, as syncfs does; another one plays a disk that fails.
  using Barrier = int (*)(int file);
  [[nodiscard]] static Outcome<DurableRecording> create(const std::filesystem::path& folder, bool overwrite,
                                                        Barrier barrier = nullptr);

  // pixels: width * height, row by row without gaps. frame.file is ignored: images are frame_000000.pgm, .. .
  // 0, or the errno of what did not work; nothing of the frame is left then.
  [[nodiscard]] int add(std::span<const std::uint8_t> pixels, int width, int height, const RecordedFrame& frame) noexcept;
  // 0, or an errno: the rows since the last sync are then not in the list. A disk that could not take the images has
  // lost some, and says so once: from then on this recording takes and lists nothing, and every call gives that errno.
  [[nodiscard]] int sync() noexcept;

  [[nodiscard]] std::uint64_t listed() const { return listed_; }
  // Frames since the last sync that did its work: not listed, and lost unless another one does.
  [[nodiscard]] std::uint64_t unlisted() const { return unlisted_; }
  // Bytes that are free where the recording lies, for an ordinary user.
  [[nodiscard]] std::uint64_t free_bytes() const noexcept;
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  UniqueFd directory_, listing_;
  std::string rows_;                         // of images that are not on the disk yet
  std::uint64_t listed_ = 0, unlisted_ = 0;  // together all images, which are numbered so
  Barrier barrier_ = nullptr;
  int lost_ = 0;  // errno of a barrier that failed
  std::int64_t listing_bytes_ = 0;
};

}  // namespace srd
