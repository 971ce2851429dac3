// SPDX-License-Identifier: Apache-2.0
// The frames of one boot that the host does not have yet, in a file, so that they outlive the process and the power.
//
// Cells of one size behind a head of one page. A frame is written to the system as it comes, which a killed process cannot
// take back; to the disk itself (fdatasync) only what the host has not taken within the sync interval, a second, by a thread
// of its own. Always the lowest free cell: while the host answers, the same few cells serve again and again, and the disk
// sees next to nothing of them. Room is taken when the file is made: a disk that fills up later takes nothing away.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "drivers/support/problem.hpp"
#include "drivers/support/unique_fd.hpp"
#include "proto/identity.hpp"

namespace srd::firmware {

using LostRanges = proto::FixedList<proto::SequenceRange, 16>;  // ascending, apart

struct SpillOptions {
  std::filesystem::path folder{};
  std::size_t frames = 0;                      // kept at most; what Sender's ring holds
  std::size_t frame_bytes = 0;                 // of the longest
  std::int64_t sync_interval = 1'000'000'000;  // ns
};

struct SpillCounts {
  std::uint64_t written = 0;        // frames
  std::uint64_t written_bytes = 0;  // to the system, with the head
  std::uint64_t syncs = 0;
  std::uint64_t failed = 0;  // frames that are not in the file
};

// What a file holds.
struct SpilledFrames {
  struct Frame {
    std::uint64_t sequence = 0;
    std::vector<std::uint8_t> encoded;
  };
  std::filesystem::path file;
  proto::BootId of;
  std::uint64_t generation = 0;  // of boots on this board: a later one has a higher number
  std::uint64_t oldest = 0;      // frames below are in the host's record, or overwritten
  std::vector<Frame> frames{};   // from oldest on, ascending, each once
  LostRanges lost{};             // below oldest: overwritten, perhaps before the host had them
  [[nodiscard]] std::uint64_t end() const { return frames.empty() ? oldest : frames.back().sequence + 1; }
};

class SpillFile {
 public:
  // kInput when the folder cannot be written or has no room.
  [[nodiscard]] static Outcome<std::unique_ptr<SpillFile>> create(const SpillOptions& options, const proto::BootId& of,
                                                                  std::uint64_t generation);
  // Everything that is whole; a file cut at any byte, or with damage anywhere, gives what is left of it. An unreadable head
  // gives frames from 0 on. kInput when it cannot be read, or a living process has it.
  [[nodiscard]] static Outcome<SpilledFrames> read(const std::filesystem::path& file);
  // The files in a folder that can be read, by generation.
  [[nodiscard]] static std::vector<SpilledFrames> read_all(const std::filesystem::path& folder);

  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;
  ~SpillFile();

  // --- one thread ---
  // Never waits for the disk itself. Frames come ascending, without gaps.
  void put(std::uint64_t sequence, std::span<const std::uint8_t> encoded);
  // Frames below are needed no more.
  // lost: of those, what was overwritten before the host had it.
  void release(std::uint64_t oldest, const LostRanges& lost);
  // Asks for a sync when frames have waited for it; call every few ms. ns, any steady clock.
  void tick(std::int64_t now);
  // All is in the host's record: there is nothing to keep.
  void remove();
  [[nodiscard]] SpillCounts counts() const;
  // Why frames are not in the file; empty: they are.
  [[nodiscard]] std::string problem() const;

 private:
  static constexpr std::uint32_t kNoCell = ~std::uint32_t{0};
  SpillFile(const SpillOptions& options, std::filesystem::path file, UniqueFd fd, const proto::BootId& of,
            std::uint64_t generation);
  [[nodiscard]] std::uint32_t take_cell();
  void give_cell(std::uint32_t cell);
  void write_head();
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes, bool frame);
  void sync_when_asked();

  std::filesystem::path file_;
  UniqueFd fd_;
  proto::BootId of_;
  std::uint64_t generation_;
  std::size_t frames_, cell_bytes_;
  std::int64_t sync_interval_;
  std::vector<std::uint64_t> free_;     // a bit a cell
  std::size_t lowest_free_ = 0;         // no word of free_ below has a bit
  std::vector<std::uint32_t> cell_of_;  // by sequence modulo frames_
  std::vector<std::uint8_t> cell_;
  std::uint64_t oldest_ = 0, next_ = 0;
  LostRanges lost_;
  std::uint64_t unsynced_ = 0;    // the first frame that may not be on the disk
  std::int64_t unsynced_ns_ = 0;  // since when that is so, as tick saw it
  bool unsynced_seen_ = false;    // by tick
  SpillCounts counts_;
  std::atomic<int> error_{0};

  std::mutex mutex_;  // of what follows
  std::condition_variable wake_;
  bool asked_ = false, ending_ = false, syncing_ = false;
  std::atomic<std::uint64_t> syncs_{0};
  std::atomic<int> sync_error_{0};
  std::thread thread_;
};

}  // namespace srd::firmware
