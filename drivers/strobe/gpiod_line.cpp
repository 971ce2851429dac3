// SPDX-License-Identifier: Apache-2.0
#include "drivers/strobe/gpiod_line.hpp"

#include <grp.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/strobe/gpiod_chip.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr unsigned kMaxListed = 40;  // lines in a message

// gpiochip0, gpiochip1, .. of the folder in the order of their numbers.
std::vector<std::string> chip_paths(const std::filesystem::path& devices) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(devices, error))
    if (entry.path().filename().string().starts_with("gpiochip")) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end(),
            [](const std::string& a, const std::string& b) { return a.size() != b.size() ? a.size() < b.size() : a < b; });
  return paths;
}

std::string chips_text(const std::filesystem::path& devices) {
  std::string text;
  for (const std::string& path : chip_paths(devices)) {
    text += text.empty() ? "" : ", ";
    if (const auto chip = GpioChip::open(path))
      text += path + " [" + chip->label() + "] (" + std::to_string(chip->line_count()) + " lines)";
    else
      text += path + " (" + std::strerror(errno) + ")";
  }
  return text.empty() ? "no GPIO chip (" + (devices / "gpiochip*").string() + ")" : text;
}

std::string lines_text(const GpioChip& chip) {
  std::string text;
  unsigned listed = 0, named = 0;
  for (unsigned offset = 0; offset < chip.line_count(); ++offset) {
    GpioLineInfo info;
    if (!chip.line(offset, info) || info.name.empty()) continue;
    if (++named > kMaxListed) continue;
    text += (listed++ == 0 ? "" : ", ") + std::to_string(offset) + " \"" + info.name + "\"" + (info.used ? " (in use)" : "");
  }
  if (named > kMaxListed) text += ", and " + std::to_string(named - kMaxListed) + " more";
  return "lines 0 to " + std::to_string(static_cast<int>(chip.line_count()) - 1) +
         (text.empty() ? ", without names" : ": " + text);
}

Problem not_permitted(const std::string& path) {
  Problem problem{Exit::kDevice, "no permission to use this GPIO chip", path, "a user that may read and write it", "", ""};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return problem;
  char buffer[1024];
  group entry{};
  group* found = nullptr;
  getgrgid_r(status.st_gid, &entry, buffer, sizeof buffer, &found);
  const std::string name = found == nullptr ? std::to_string(status.st_gid) : std::string(found->gr_name);
  problem.found = "it belongs to the group " + name;
  problem.advice = status.st_gid == 0 ? "install the package's udev rule, which gives it to the group gpio"
                                      : "add the user to that group: sudo usermod -aG " + name + " USER, then log in again";
  return problem;
}

struct FoundChip {
  std::string path;
  std::unique_ptr<GpioChip> chip;
};

bool refused() { return errno == EACCES || errno == EPERM; }

// Of the chips that can be opened, the first that fits; null: none does. refused_path: of the first one that this user may
// not open. It may be the one that is meant: its label and its lines cannot be known.
template <class Fits>
FoundChip first_chip(const std::filesystem::path& devices, std::string& refused_path, const Fits& fits) {
  for (const std::string& path : chip_paths(devices)) {
    FoundChip found{path, GpioChip::open(path)};
    if (!found.chip && refused() && refused_path.empty()) refused_path = path;
    if (found.chip && fits(found)) return found;
  }
  return {};
}

// By path or device file, else by name or label among those present.
Outcome<FoundChip> find_chip(const std::string& wanted, const std::filesystem::path& devices) {
  std::error_code error;
  const bool is_path = wanted.find('/') != std::string::npos;
  if (is_path || std::filesystem::exists(devices / wanted, error)) {
    const std::string path = is_path ? wanted : (devices / wanted).string();
    if (auto chip = GpioChip::open(path)) return FoundChip{path, std::move(chip)};
    if (refused()) return not_permitted(path);
    return Problem{Exit::kDevice,
                   std::string("this is no GPIO chip that can be opened: ") + std::strerror(errno),
                   path,
                   "a GPIO chip",
                   chips_text(devices),
                   "give strobe.chip one of those, by path, name or label"};
  }
  std::string refused_path;
  FoundChip found = first_chip(devices, refused_path,
                               [&](const FoundChip& one) { return one.chip->name() == wanted || one.chip->label() == wanted; });
  if (found.chip) return found;
  if (!refused_path.empty()) return not_permitted(refused_path);
  return Problem{Exit::kDevice,
                 "no GPIO chip of this name or label",
                 wanted,
                 "a GPIO chip",
                 chips_text(devices),
                 "give strobe.chip one of those, by path, name or label"};
}

std::optional<unsigned> line_of_name(const GpioChip& chip, const std::string& wanted) {
  for (unsigned offset = 0; offset < chip.line_count(); ++offset) {
    GpioLineInfo info;
    if (chip.line(offset, info) && info.name == wanted) return offset;
  }
  return std::nullopt;
}

// A number is taken as one only when no line has it as its name.
std::optional<unsigned> find_line(const GpioChip& chip, const std::string& wanted) {
  if (const auto named = line_of_name(chip, wanted)) return named;
  const auto number = parse_number<unsigned>(wanted);
  return number && *number < chip.line_count() ? number : std::nullopt;
}

Outcome<std::unique_ptr<OutputLine>> request(const FoundChip& found, unsigned offset, const LineAddress& address,
                                             const std::string& consumer) {
  if (auto line = found.chip->request(offset, address.active_low, consumer)) return line;
  const int error = errno;
  const std::string where = found.path + " line " + std::to_string(offset);
  GpioLineInfo info;
  if (error == EBUSY && found.chip->line(offset, info))
    return Problem{Exit::kDevice,
                   "this GPIO line is in use",
                   where,
                   "a line that nobody uses",
                   "used by \"" + (info.consumer.empty() ? "unknown" : info.consumer) + "\"",
                   "end that program, or choose another line; the kernel's own uses are in the device tree"};
  if (error == EACCES || error == EPERM) return not_permitted(found.path);
  return Problem{Exit::kDevice,
                 std::string("this GPIO line cannot be an output: ") + std::strerror(error),
                 where,
                 "a line that can be an output",
                 lines_text(*found.chip),
                 ""};
}

}  // namespace

std::string gpiod_version() { return "libgpiod " + GpioChip::library_version(); }

Outcome<std::unique_ptr<OutputLine>> open_gpiod_line(const LineAddress& address, const std::string& consumer,
                                                     const std::filesystem::path& devices) {
  if (!address.chip.empty()) {
    auto found = find_chip(address.chip, devices);
    if (!found) return found.error();
    const auto offset = find_line(*found->chip, address.line);
    if (!offset)
      return Problem{Exit::kDevice,
                     "no line \"" + address.line + "\" on this GPIO chip",
                     found->path,
                     "a line's number or name",
                     lines_text(*found->chip),
                     "see gpioinfo"};
    return request(*found, *offset, address, consumer);
  }
  // Only a name says which chip is meant.
  std::string refused_path;
  std::optional<unsigned> offset;
  const FoundChip found = first_chip(devices, refused_path, [&](const FoundChip& one) {
    offset = line_of_name(*one.chip, address.line);
    return offset.has_value();
  });
  if (found.chip) return request(found, *offset, address, consumer);
  if (!refused_path.empty()) return not_permitted(refused_path);
  return Problem{Exit::kDevice,
                 "no GPIO line has the name \"" + address.line + "\"",
                 "",
                 "a line's name, or strobe.chip and a number",
                 chips_text(devices),
                 "see gpioinfo"};
}

}  // namespace srd
