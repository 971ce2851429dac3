// SPDX-License-Identifier: Apache-2.0
#include "firmware/service/last_end.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "drivers/support/text_file.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd::firmware {

namespace {

constexpr const char* kName = "last_end";
constexpr std::string_view kKilled = "ended without a word: killed, or the power went";
constexpr std::array kFatal{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

// For the handler: everything is put together beforehand.
constexpr std::size_t kMaxPath = 4096;
std::array<char, kMaxPath> handler_file{}, handler_temporary{};
std::array<char, 16> handler_count{};  // "12\n"

// The whole file at once or not at all, with calls that a signal handler may make.
void replace(const char* temporary, const char* file, const char* count, const char* text, std::size_t text_bytes) {
  const int fd = ::open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return;
  bool good = ::write(fd, count, std::strlen(count)) >= 0;
  good = good && ::write(fd, text, text_bytes) == static_cast<ssize_t>(text_bytes);
  good = good && ::write(fd, "\n", 1) == 1 && ::fsync(fd) == 0;
  (void)::close(fd);
  if (good) (void)::rename(temporary, file);
}

const char* words_for(int signal, bool by_another) {
  switch (signal) {
    case SIGSEGV: return "SIGSEGV: memory that is not there";
    case SIGBUS: return "SIGBUS: memory or a file that went away";
    case SIGFPE: return "SIGFPE: a number that cannot be";
    case SIGILL: return "SIGILL: an instruction that this processor does not know";
    default: return by_another ? "SIGABRT from outside: the watchdog saw no frame" : "SIGABRT: a broken assumption";
  }
}

void on_fatal(int signal, siginfo_t* info, void*) {
  const bool by_another = info != nullptr && info->si_code <= 0 && info->si_pid != ::getpid();
  const char* words = words_for(signal, by_another);
  replace(handler_temporary.data(), handler_file.data(), handler_count.data(), words, std::strlen(words));
  // SA_RESETHAND: the second time it ends the process, with a core where that is wanted.
  (void)::raise(signal);
}

std::string printable(std::string_view text) {
  std::string out(text.substr(0, LastEnd::kMaxText));
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = ' ';
  return out;
}

}  // namespace

std::filesystem::path LastEnd::service_folder() {
  const char* folders = std::getenv("STATE_DIRECTORY");
  if (folders == nullptr) return {};
  const std::string_view all = folders;
  return std::filesystem::path(all.substr(0, all.find(':')));
}

Outcome<LastEnd> LastEnd::open(const std::filesystem::path& folder) {
  LastEnd made;
  if (folder.empty()) return made;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  made.file_ = std::filesystem::absolute(folder, error) / kName;
  if (std::filesystem::exists(made.file_, error)) {
    made.restarts_ = 1;
    made.text_ = kKilled;
    // A file that somebody spoilt still means that the node did not end as it should.
    if (const auto text = read_text_file(made.file_, "how the node ended", 4096); text.ok()) {
      const auto lines = split_lines(*text);
      if (lines.size() >= 2)
        if (const auto count = parse_number<std::uint32_t>(trimmed(lines[0].text)); count && *count < UINT32_MAX) {
          made.restarts_ = *count + 1;
          made.text_ = printable(lines[1].text);
        }
    }
  }
  made.write(kKilled);
  if (!std::filesystem::exists(made.file_, error))
    return Problem{Exit::kInput,
                   "cannot keep how the node ended",
                   made.file_.string(),
                   "a writable folder",
                   "",
                   "check node.state, or --state, and the folder's permissions"};
  return made;
}

void LastEnd::write(std::string_view reason) const {
  if (file_.empty()) return;
  const std::string count = std::to_string(restarts_) + "\n", text = printable(reason);
  replace((file_.string() + ".new").c_str(), file_.c_str(), count.c_str(), text.data(), text.size());
}

void LastEnd::clear() const {
  std::error_code error;
  if (!file_.empty()) std::filesystem::remove(file_, error);
}

void LastEnd::catch_fatal_signals() const {
  const std::string temporary = file_.string() + ".new", count = std::to_string(restarts_) + "\n";
  if (file_.empty() || temporary.size() >= kMaxPath) return;
  std::strcpy(handler_file.data(), file_.c_str());
  std::strcpy(handler_temporary.data(), temporary.c_str());
  std::strcpy(handler_count.data(), count.c_str());
  struct sigaction action {};
  action.sa_sigaction = on_fatal;
  action.sa_flags = SA_SIGINFO | static_cast<int>(SA_RESETHAND);
  ::sigemptyset(&action.sa_mask);
  for (const int signal : kFatal) ::sigaction(signal, &action, nullptr);
}

void LastEnd::clear_from_signal() {
  if (handler_file[0] != '\0') (void)::unlink(handler_file.data());
}

}  // namespace srd::firmware
