// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/key_file.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "drivers/support/text_file.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd {
namespace {

constexpr std::string_view kWord = "flume-srd-key-1";
constexpr std::string_view kForm = "flume-srd-key-1 NODE and 64 hexadecimal digits";
constexpr std::size_t kDigits = 2 * SecretBytes::kBytes;

// Of a key file; wiped when it goes.
struct SecretText {
  std::array<char, 1024> text{};
  std::size_t size = 0;
  SecretText() = default;
  SecretText(const SecretText&) = delete;
  SecretText& operator=(const SecretText&) = delete;
  ~SecretText() { sodium_memzero(text.data(), text.size()); }
};

std::string quoted(const std::filesystem::path& file) {
  const std::string text = file.string();
  const bool plain = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '-' || c == '_';
  });
  return plain ? text : "'" + text + "'";
}

std::string user_name(uid_t user) {
  const passwd* entry = ::getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

Problem unreadable(const std::filesystem::path& file, int error) {
  Problem problem{
      Exit::kUsage, std::string("cannot read the key: ") + std::strerror(error), file.string(), "a key file", "", ""};
  if (error == ENOENT) problem.advice = "srd keygen on the host makes one";
  if (error == EACCES || error == EPERM)
    problem.advice = "chown " + user_name(::geteuid()) + ": " + quoted(file) + " && chmod 600 " + quoted(file) +
                     " (as root; folders above it must let the user through)";
  return problem;
}

// Looks at the open file: nobody can put another one in its place between the look and the reading.
std::optional<Problem> exposed(const std::filesystem::path& file, const struct stat& info) {
  if (!S_ISREG(info.st_mode))
    return Problem{Exit::kUsage, "the key is no file", file.string(), "a key file", "a folder or a device", ""};
  if ((info.st_mode & 077) != 0) {
    std::array<char, 8> mode{};
    std::snprintf(mode.data(), mode.size(), "%03o", static_cast<unsigned>(info.st_mode & 0777));
    return Problem{Exit::kUsage,
                   "others than its owner have access to the key",
                   file.string(),
                   "mode 600 or 400",
                   "mode " + std::string(mode.data()),
                   "chmod 600 " + quoted(file) + "; where someone may have read it, also: srd keygen --change"};
  }
  if (info.st_uid != ::geteuid() && info.st_uid != 0 && ::geteuid() != 0)
    return Problem{Exit::kUsage,           "the key belongs to another user",
                   file.string(),          user_name(::geteuid()),
                   user_name(info.st_uid), "chown " + user_name(::geteuid()) + ": " + quoted(file)};
  return std::nullopt;
}

bool take_key_line(std::string_view line, KeyFile& into) {
  const auto word = [&line] {
    const std::string_view taken = line.substr(0, line.find(' '));
    line.remove_prefix(std::min(line.size(), taken.size() + 1));
    return taken;
  };
  const std::string_view first = word(), node = word(), digits = word();
  if (first != kWord || node.empty() || !line.empty() || digits.size() != kDigits) return false;
  if (!into.node.empty() && into.node != node) return false;
  SecretBytes key;
  std::size_t bytes = 0;
  if (sodium_hex2bin(key.bytes().data(), SecretBytes::kBytes, digits.data(), digits.size(), nullptr, &bytes, nullptr) != 0 ||
      bytes != SecretBytes::kBytes)
    return false;
  into.node = node;
  into.keys.push_back(key);
  return into.keys.size() <= KeyFile::kMostKeys;
}

// Both from being written to and from being lost by a power cut.
bool write_whole(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t bytes = ::write(fd, text.data(), text.size());
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(bytes));
  }
  return ::fsync(fd) == 0;
}

}  // namespace

SecretBytes::~SecretBytes() { sodium_memzero(bytes_.data(), bytes_.size()); }

SecretBytes SecretBytes::random() {
  static const int ready = sodium_init();
  (void)ready;
  SecretBytes made;
  randombytes_buf(made.bytes_.data(), made.bytes_.size());
  return made;
}

bool operator==(const SecretBytes& a, const SecretBytes& b) {
  return sodium_memcmp(a.bytes_.data(), b.bytes_.data(), SecretBytes::kBytes) == 0;
}

Outcome<KeyFile> KeyFile::read(const std::filesystem::path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  if (!fd.valid()) return unreadable(file, errno);
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0) return unreadable(file, errno);
  if (auto problem = exposed(file, info)) return *problem;
  SecretText secret;
  const auto not_a_key = [&](int line) {
    // What is there may be a key with a slip: it is not shown.
    return Problem{Exit::kUsage,       "not a key file", file.string() + ":" + std::to_string(line),
                   std::string(kForm), "something else", "srd keygen makes one"};
  };
  while (secret.size < secret.text.size()) {
    const ssize_t bytes = ::read(fd.get(), secret.text.data() + secret.size, secret.text.size() - secret.size);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) return unreadable(file, errno);
    if (bytes == 0) break;
    secret.size += static_cast<std::size_t>(bytes);
  }
  if (secret.size == secret.text.size()) return not_a_key(1);
  KeyFile out;
  out.keys.reserve(kMostKeys + 1);
  int last = 1;
  for (const TextLine& line : split_lines({secret.text.data(), secret.size})) {
    last = line.number;
    const std::string_view text = trimmed(line.text);
    if (text.empty() || text.front() == '#') continue;
    if (!take_key_line(text, out)) return not_a_key(line.number);
  }
  if (out.keys.empty()) return not_a_key(last);
  return out;
}

Outcome<void> KeyFile::write(const std::filesystem::path& file) const {
  const auto failed = [&](const char* action, int error) {
    return Problem{Exit::kInput, std::string("cannot ") + action + ": " + std::strerror(error), file.string(), "", "", ""};
  };
  SecretText secret;
  const auto add = [&secret](std::string_view text) {
    std::copy(text.begin(), text.end(), secret.text.begin() + static_cast<std::ptrdiff_t>(secret.size));
    secret.size += text.size();
  };
  add("# Secret of a node of Flume SRD: whoever reads it can send in its name. At node and host, mode 600.\n");
  for (const SecretBytes& key : keys) {
    add(kWord);
    add(" ");
    add(node);
    add(" ");
    std::array<char, kDigits + 1> digits{};
    sodium_bin2hex(digits.data(), digits.size(), key.bytes().data(), SecretBytes::kBytes);
    add({digits.data(), kDigits});
    sodium_memzero(digits.data(), digits.size());
    add("\n");
  }
  std::filesystem::path part = file;
  part += ".part";
  (void)::unlink(part.c_str());
  UniqueFd fd(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!fd.valid()) return failed("write the key", errno);
  if (!write_whole(fd.get(), {secret.text.data(), secret.size})) {
    const int error = errno;
    (void)::unlink(part.c_str());
    return failed("write the key", error);
  }
  if (::rename(part.c_str(), file.c_str()) != 0) return failed("name the key", errno);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const UniqueFd entry(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (entry.valid()) (void)::fsync(entry.get());
  return {};
}

}  // namespace srd
