// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "drivers/support/unique_fd.hpp"
#include "firmware/doctor/doctor.hpp"
#include "proto/node_codec.hpp"

namespace srd::firmware {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kHeadroom = 1.5;  // a disk has slow moments

std::filesystem::path nearest_folder(std::filesystem::path folder) {
  std::error_code error;
  folder = std::filesystem::absolute(folder, error);
  while (!std::filesystem::is_directory(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

// MB a second that reach the disk in this folder; negative: minus the errno.
double write_rate(const std::filesystem::path& folder, std::uint64_t bytes) {
  std::string name = (folder / ".srd-doctor-XXXXXX").string();
  const UniqueFd file(::mkostemp(name.data(), O_CLOEXEC));
  if (!file.valid()) return -errno;
  (void)::unlink(name.c_str());
  const std::vector<char> block(1 << 20, 'd');
  const auto begin = Clock::now();
  for (std::uint64_t done = 0; done < bytes; done += block.size())
    if (::write(file.get(), block.data(), block.size()) != static_cast<ssize_t>(block.size()))
      return -(errno != 0 ? errno : ENOSPC);
  if (::fdatasync(file.get()) != 0) return -errno;
  return static_cast<double>(bytes) / 1e6 / std::chrono::duration<double>(Clock::now() - begin).count();
}

// What the camera gives, MB a second; 0 when its size is not known.
double camera_rate(const NodeConfig& config) {
  const auto instrument = make_instrument(config);
  if (!instrument) return 0;
  return static_cast<double>(instrument->width) * instrument->height * config.frame_rate_hz / 1e6;
}

}  // namespace

// A spill takes all of its room at the start.
static void check_spill(const NodeConfig& config, Diagnosis& diagnosis) {
  if (config.spill.empty()) return;
  const std::filesystem::path folder = nearest_folder(config.spill);
  const std::uint64_t bytes = config.ring_frames * (proto::most_frame_bytes(config.modes) + 64);
  std::error_code error;
  const std::uint64_t free = std::filesystem::space(folder, error).available;
  if (error || free < bytes || ::access(folder.c_str(), W_OK) != 0)
    diagnosis.fail(Exit::kInput, "spill",
                   folder.string() + ": " + (error ? error.message() : std::to_string(free >> 20) + " MiB free"),
                   "a folder that the node's user may write, with " + std::to_string((bytes >> 20) + 1) + " MiB of room");
  else
    diagnosis.ok("spill", config.spill.string() + ": " + std::to_string(config.ring_frames) + " frames");
}

void check_disk(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis) {
  check_spill(config, diagnosis);
  if (config.recording.folder.empty()) {
    diagnosis.ok("disk", "nothing is recorded");
    return;
  }
  const std::filesystem::path folder = nearest_folder(config.recording.folder);
  std::error_code error;
  const std::uint64_t free_mib = std::filesystem::space(folder, error).available >> 20;
  if (error || free_mib < config.recording.min_free_mib) {
    diagnosis.fail(Exit::kInput, "disk",
                   folder.string() + ": " + (error ? error.message() : std::to_string(free_mib) + " MiB free"),
                   "room for more than record.min_free_mib, " + std::to_string(config.recording.min_free_mib) + " MiB");
    return;
  }
  const double rate = write_rate(folder, options.write_bytes), needed = camera_rate(config);
  const auto whole = [](double mb) { return std::to_string(static_cast<long>(mb)); };
  if (rate < 0) {
    diagnosis.fail(Exit::kInput, "disk", folder.string() + ": " + std::strerror(static_cast<int>(-rate)),
                   "a folder that the node's user may write (ReadWritePaths= in the unit)");
    return;
  }
  std::string found = folder.string() + ": " + std::to_string(free_mib) + " MiB free, writes " + whole(rate) + " MB/s";
  if (needed > 0) {
    const double minutes = static_cast<double>(free_mib - config.recording.min_free_mib) * 1.048576 / needed / 60;
    found += "; the camera gives " + whole(needed) + " MB/s, room for " + whole(minutes) + " min";
  }
  if (rate < kHeadroom * needed)
    diagnosis.warn("disk", found, "a faster disk (USB 3, NVMe), a lower rate, or a longer record.queue_frames");
  else
    diagnosis.ok("disk", found);
}

}  // namespace srd::firmware
