// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/durable_recording.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <utility>

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReserved = 1 << 16;  // of rows: some thousand frames between two syncs

Problem unwritable(const fs::path& what, int error) {
  return {Exit::kInput,         "cannot be written",
          what.string(),        "a writable folder with room",
          std::strerror(error), "check the folder, its permissions and the disk"};
}

// All bytes, or an errno.
int write_all(int fd, const void* bytes, std::size_t size) noexcept {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t done = ::write(fd, at, size);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return done < 0 ? errno : ENOSPC;
    at += done;
    size -= static_cast<std::size_t>(done);
  }
  return 0;
}

}  // namespace

Outcome<DurableRecording> DurableRecording::create(const fs::path& folder, bool overwrite, Barrier barrier) {
  const Outcome<fs::path> made_folder = make_recording_folder(folder, overwrite);
  if (!made_folder) return made_folder.error();
  const fs::path& listing = *made_folder;
  std::error_code error;
  DurableRecording made;
  made.folder_ = folder;
  made.barrier_ = barrier != nullptr ? barrier : &::syncfs;
  made.directory_ = UniqueFd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!made.directory_.valid()) return unwritable(folder, errno);
  made.listing_ = UniqueFd(::open(listing.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_APPEND, 0644));
  if (!made.listing_.valid()) return unwritable(listing, errno);
  const std::string header = std::string(kFramesHeader) + "\n";
  if (const int failure = write_all(made.listing_.get(), header.data(), header.size()); failure != 0)
    return unwritable(listing, failure);
  for (const std::string_view stale : {kTruthName, kReferenceName}) fs::remove(folder / stale, error);
  if (::fsync(made.listing_.get()) != 0 || ::fsync(made.directory_.get()) != 0) return unwritable(listing, errno);
  made.listing_bytes_ = static_cast<std::int64_t>(header.size());
  made.rows_.reserve(kReserved);
  return made;
}

int DurableRecording::add(std::span<const std::uint8_t> pixels, int width, int height, const RecordedFrame& frame) noexcept {
  if (lost_ != 0) return lost_;
  std::array<char, 32> name;
  std::snprintf(name.data(), name.size(), "frame_%06" PRIu64 ".pgm", listed_ + unlisted_);
  const UniqueFd file(::openat(directory_.get(), name.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file.valid()) return errno;
  std::array<char, 32> header;
  const int header_bytes = std::snprintf(header.data(), header.size(), "P5\n%d %d\n255\n", width, height);
  int failure = write_all(file.get(), header.data(), static_cast<std::size_t>(header_bytes));
  if (failure == 0) failure = write_all(file.get(), pixels.data(), pixels.size());
  if (failure != 0) {
    (void)::unlinkat(directory_.get(), name.data(), 0);
    return failure;
  }
  // The disk starts now: little is left to wait for at the next sync.
  (void)::sync_file_range(file.get(), 0, 0, SYNC_FILE_RANGE_WRITE);
  std::array<char, 128> row;
  const int row_bytes = std::snprintf(row.data(), row.size(), "%s,%" PRIu64 ",%" PRId64 ",%" PRIu32 ",%d\n", name.data(),
                                      frame.sequence, frame.time_ns, frame.exposure_us, static_cast<int>(frame.strobe));
  rows_.append(row.data(), static_cast<std::size_t>(row_bytes));
  ++unlisted_;
  return 0;
}

int DurableRecording::sync() noexcept {
  if (lost_ != 0) return lost_;
  if (unlisted_ == 0) return 0;
  // One barrier for all images, their sizes and names; a sync of each would wait for the disk once an image. The kernel
  // reports what it could not write once; the next barrier would pass for a good one.
  if (barrier_(directory_.get()) != 0) return lost_ = errno;
  int failure = write_all(listing_.get(), rows_.data(), rows_.size());
  if (failure == 0 && ::fdatasync(listing_.get()) != 0) failure = errno;
  if (failure != 0) {
    (void)::ftruncate(listing_.get(), static_cast<off_t>(listing_bytes_));
    return failure;
  }
  listing_bytes_ += static_cast<std::int64_t>(rows_.size());
  rows_.clear();
  listed_ += std::exchange(unlisted_, 0);
  return 0;
}

std::uint64_t DurableRecording::free_bytes() const noexcept {
  struct statvfs64 space {};
  if (::fstatvfs64(directory_.get(), &space) != 0) return 0;
  return static_cast<std::uint64_t>(space.f_bavail) * space.f_frsize;
}

}  // namespace srd
