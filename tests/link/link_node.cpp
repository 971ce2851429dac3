// SPDX-License-Identifier: Apache-2.0
// A node without camera: made-up frames through the node's own transmitter, at a steady rate, until SIGTERM or so many frames.
// Prints "frames N lost L unacknowledged U" at its end. With COUNT the number of frames given so far is in that file all the
// time, also after it was killed.
// usage: srd_link_node ID[,ID..] HOST:PORT HZ FRAMES [--key FILE] [--spill DIR] [--count FILE]
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "drivers/support/key_file.hpp"
#include "drivers/support/system_clock.hpp"
#include "firmware/transmit/transmitter.hpp"

namespace {

using namespace srd;
using firmware::Transmitter;

std::atomic<bool> stop_asked{false};

proto::CoefficientFrame frame_now(std::uint64_t number) {
  proto::CoefficientFrame frame;
  frame.stamp = {clock_ns(CLOCK_MONOTONIC), ClockId::kMonotonic, clock_ns(CLOCK_REALTIME), 1000};
  frame.status = proto::FrameStatus::kOk;
  frame.model.modes = dsp::ModeList::standard(12).value();
  frame.model.lx = frame.model.ly = 200;
  frame.refractive_index = 1.333f;
  frame.source_sequence = number;
  frame.coefficients.setConstant(12, static_cast<float>(number % 1000));
  frame.information.size = 12;
  for (int i = 0; i < 12; ++i) {
    frame.information.scale[static_cast<std::size_t>(i)] = 1;
    frame.information.entries[proto::InformationFactor::index(i, i)] = 32000;
  }
  return frame;
}

const char* option(int argc, char** argv, const char* name) {
  for (int i = 5; i + 1 < argc; i += 2)
    if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
  return nullptr;
}

std::unique_ptr<Transmitter> start(const std::string& id, int argc, char** argv) {
  firmware::TransmitterOptions options;
  std::random_device device;
  options.sender.from = {*proto::NodeId::make(id), (std::uint64_t{device()} << 32) | device()};
  options.sender.ring_frames = 20000;
  options.sender.ring_bytes = 20000 * 600;
  options.host = argv[2];
  if (const char* file = option(argc, argv, "--key")) {
    const auto key = KeyFile::read(file);
    if (!key) {
      (void)std::fputs(key.error().text().c_str(), stderr);
      return nullptr;
    }
    options.sender.key = proto::Key(key->keys.front().bytes());
  }
  if (const char* folder = option(argc, argv, "--spill"))
    options.spill = {.folder = folder,
                     .frames = options.sender.ring_frames,
                     .frame_bytes = proto::most_frame_bytes(dsp::ModeList::standard(12).value())};
  auto made = Transmitter::start(options);
  if (made.ok() && !(*made)->spill_note().empty()) (void)std::fprintf(stderr, "%s\n", (*made)->spill_note().c_str());
  if (made.ok()) return std::move(*made);
  (void)std::fputs(made.error().text().c_str(), stderr);
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  (void)std::signal(SIGTERM, [](int) { stop_asked = true; });
  std::vector<std::unique_ptr<Transmitter>> nodes;
  std::string ids = argv[1];
  for (std::size_t at = 0; at <= ids.size();) {
    const std::size_t end = std::min(ids.find(',', at), ids.size());
    nodes.push_back(start(ids.substr(at, end - at), argc, argv));
    if (!nodes.back()) return 2;
    at = end + 1;
  }
  const auto period = std::chrono::duration<double>(1 / std::atof(argv[3]));
  const std::uint64_t frames = std::strtoull(argv[4], nullptr, 10);
  const char* count_file = option(argc, argv, "--count");
  const UniqueFd count(count_file != nullptr ? ::open(count_file, O_WRONLY | O_CREAT | O_CLOEXEC, 0644) : -1);
  const auto begin = std::chrono::steady_clock::now();
  std::uint64_t given = 0, refused = 0;
  for (; given < frames && !stop_asked; ++given) {
    std::this_thread::sleep_until(begin +
                                  std::chrono::duration_cast<std::chrono::nanoseconds>(period * static_cast<double>(given)));
    for (auto& node : nodes) refused += node->push(frame_now(given)) ? 0 : 1;
    if (count.valid()) {
      const std::uint64_t now_given = given + 1;
      (void)!::pwrite(count.get(), &now_given, sizeof now_given, 0);
    }
  }
  std::uint64_t lost = refused, unacknowledged = 0;
  for (auto& node : nodes) {
    const auto report = node->finish();
    lost += report.counts.lost;
    unacknowledged += report.unacknowledged;
  }
  std::printf("frames %llu lost %llu unacknowledged %llu\n", static_cast<unsigned long long>(given),
              static_cast<unsigned long long>(lost), static_cast<unsigned long long>(unacknowledged));
  return lost + unacknowledged == 0 ? 0 : 1;
}
