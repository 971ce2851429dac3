// SPDX-License-Identifier: Apache-2.0
#include "firmware/stills/still_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "drivers/recording/image_file.hpp"
#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd::firmware {

namespace {

constexpr std::string_view kBefore = "still_", kBehind = ".png";
constexpr unsigned kMostNumber = 999'999'999;

std::string name_of(unsigned number) { return formatted("still_%03u.png", number); }

// 0: no still's name.
unsigned number_of(const std::string& name) {
  if (!name.starts_with(kBefore) || !name.ends_with(kBehind) || name.size() <= kBefore.size() + kBehind.size()) return 0;
  const std::string_view digits = std::string_view(name).substr(kBefore.size(), name.size() - kBefore.size() - kBehind.size());
  const auto number = parse_number<unsigned>(digits);
  return number && *number < kMostNumber ? *number : 0;
}

bool bring_to_disk(const std::filesystem::path& path, int flags) {
  const UniqueFd file(::open(path.c_str(), flags | O_CLOEXEC));
  return file.get() >= 0 && ::fsync(file.get()) == 0;
}

// 0, EEXIST when there is a file of that name, or another errno.
int rename_to_unused(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // A file system that cannot refuse by itself (NFS): nobody else writes names of this kind into the folder.
  std::error_code error;
  if (std::filesystem::exists(to, error)) return EEXIST;
  return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

Problem refused(const std::filesystem::path& folder, const std::string& found) {
  return {Exit::kInput, "no still can be written",          folder.string(), "a folder that takes images",
          found,        "make room, or name another folder"};
}

}  // namespace

Outcome<StillFolder> StillFolder::open(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  StillFolder made;
  made.folder_ = folder;
  if (!error)
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
      made.last_ = std::max(made.last_, number_of(entry->path().filename().string()));
  if (error) return refused(folder, error.message());
  if (::access(folder.c_str(), W_OK | X_OK) != 0) return refused(folder, std::strerror(errno));
  return made;
}

Outcome<std::string> StillFolder::add(const GrayView& image) {
  const std::filesystem::path half = folder_ / (".half_of_" + name_of(last_ + 1));
  std::error_code ignored;
  if (auto written = write_gray_image(half, image); !written) {
    std::filesystem::remove(half, ignored);
    return written.error();
  }
  int failure = bring_to_disk(half, O_RDONLY) ? EEXIST : errno;
  while (failure == EEXIST) failure = rename_to_unused(half, folder_ / name_of(++last_));
  if (failure != 0) {
    std::filesystem::remove(half, ignored);
    return refused(folder_, std::strerror(failure));
  }
  (void)bring_to_disk(folder_, O_RDONLY | O_DIRECTORY);  // the image is whole either way
  return name_of(last_);
}

}  // namespace srd::firmware
