// SPDX-License-Identifier: Apache-2.0
#include "host/listen/command.hpp"

#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "host/fusion/fusion_file.hpp"
#include "host/listen/listen.hpp"

namespace srd::host {
namespace {

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // or a signal handler may not use it

void ask_to_stop(int) { stop_asked.store(true); }

// SIGINT and SIGTERM end the run cleanly while this lives; a second one ends the program.
class StopSignals {
 public:
  StopSignals() {
    stop_asked.store(false);
    struct sigaction action {};
    action.sa_handler = ask_to_stop;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    ::sigaction(SIGINT, &action, &interrupt_);
    ::sigaction(SIGTERM, &action, &terminate_);
  }
  ~StopSignals() {
    ::sigaction(SIGINT, &interrupt_, nullptr);
    ::sigaction(SIGTERM, &terminate_, nullptr);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

 private:
  struct sigaction interrupt_ {
  }, terminate_{};
};

// A line at the bottom of a terminal, rewritten in place.
class TerminalLine {
 public:
  void show(const std::string& line) {
    std::fprintf(stderr, "\r%s\033[K", line.c_str());
    std::fflush(stderr);
    shown_ = true;
  }
  void say(const std::string& text) {
    if (shown_) std::fputs("\r\033[K", stderr);
    shown_ = false;
    std::fputs(text.c_str(), stderr);
    if (!text.ends_with('\n')) std::fputc('\n', stderr);
    std::fflush(stderr);
  }

 private:
  bool shown_ = false;
};

int run(ListenOptions options) {
  const StopSignals signals;
  TerminalLine terminal;
  options.notify = [&](const std::string& text) { terminal.say(text); };
  if (::isatty(STDERR_FILENO) == 1) options.show = [&](const std::string& line) { terminal.show(line); };
  options.listening = [&](const Address& address) {
    if (options.show) terminal.say("listening on " + address.text());
  };
  const auto done = listen(options, stop_asked);
  if (done.ok()) return static_cast<int>(Exit::kDone);
  terminal.say(done.error().text());
  return static_cast<int>(done.error().exit);
}

}  // namespace

void add_listen_command(CLI::App& app, int& exit_code) {
  struct Given {
    ListenOptions options;
    bool append = false, force = false, fuse = false;
    std::filesystem::path boards;
  };
  auto given = std::make_shared<Given>();
  CLI::App* command = app.add_subcommand("listen", "Receive the frames of any number of nodes and write their coefficients");
  command->add_option("--bind", given->options.bind, "Address to listen on (ADDR:PORT)")->capture_default_str();
  command->add_option("--csv", given->options.csv, "Record to write; frames are acknowledged once they are in it");
  command->add_option("--record", given->options.record,
                      "Folder of MCAP files with every frame as its node sent it; gone on with where it is there");
  command->add_option("--keys", given->options.keys,
                      "Folder of nodes' keys (srd keygen): only what they prove is accepted and acknowledged");
  command->add_option("--count", given->options.count, "End after so many rows")->check(CLI::PositiveNumber);
  command->add_option("--for", given->options.seconds, "End after so many seconds")->check(CLI::PositiveNumber);
  auto* append = command->add_flag("--append", given->append, "Go on with an existing file; no frame is written twice");
  auto* force = command->add_flag("--force", given->force, "Write an existing file anew");
  command->add_flag("--fuse", given->fuse, "Also write one surface of all boards, as of a node named fused");
  command->add_option("--boards", given->boards, "Which boards see one surface, and where each lies (TOML); implies --fuse");
  append->excludes(force)->needs("--csv");
  force->needs("--csv");
  command->footer(
      "A node with another list of modes than the first gets a file of its own beside FILE: run.csv, run.A00-B-C.csv.\n"
      "run.csv.model.toml says lengths, origin, index and pattern of each node. Without --csv and --record nothing is kept. "
      "Frames are acknowledged once they are in both.\n"
      "--fuse wants boards whose clocks agree (chrony, PTP): frames are brought to one moment by their wall times.");
  command->callback([given, &exit_code] {
    if (given->append) given->options.open = OpenMode::kAppend;
    if (given->force) given->options.open = OpenMode::kReplace;
    if (given->fuse || !given->boards.empty()) given->options.fuse.emplace();
    if (!given->boards.empty()) {
      if (const auto read = read_fusion_file(given->boards, *given->options.fuse); !read) {
        std::fputs(read.error().text().c_str(), stderr);
        exit_code = static_cast<int>(read.error().exit);
        return;
      }
    }
    exit_code = run(given->options);
  });
}

}  // namespace srd::host
