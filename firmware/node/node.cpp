#include "firmware/node/node.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <sstream>
#include <thread>

#include "drivers/support/rank_text.hpp"

namespace srd::firmware {

namespace {

constexpr auto kWatchInterval = std::chrono::milliseconds(20);
constexpr auto kStatusInterval = std::chrono::seconds(1);

std::uint64_t random_boot() {
  std::random_device device;
  std::uint64_t boot = 0;
  while (boot == 0) boot = (static_cast<std::uint64_t>(device()) << 32) | device();
  return boot;
}

std::uint64_t value(const std::atomic<std::uint64_t>& counter) { return counter.load(std::memory_order_relaxed); }

// Rates are those of the last second.
class StatusMaker {
 public:
  proto::NodeStatus make(const FrameCounters& counters, double seconds, bool stopping) {
    proto::NodeStatus status;
    status.state = stopping ? proto::NodeState::kStopping
                            : static_cast<proto::NodeState>(counters.state.load(std::memory_order_relaxed));
    const std::uint64_t captured = value(counters.captured), records = value(counters.records);
    status.capture_hz = static_cast<float>(static_cast<double>(captured - captured_) / seconds);
    status.record_hz = static_cast<float>(static_cast<double>(records - records_) / seconds);
    captured_ = captured;
    records_ = records;
    status.dropped_by_source = value(counters.dropped_by_source);
    status.dropped_late = value(counters.dropped_late);
    status.dropped_bad = value(counters.bad);
    return status;
  }

 private:
  std::uint64_t captured_ = 0, records_ = 0;
};

}  // namespace

Outcome<RunReport> run_node(const NodeConfig& config, Instrument& instrument, std::uint64_t frames,
                            const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  Camera& camera = *instrument.camera;
  if (auto started = camera.start(); !started) return started.error();
  if (camera.width() != instrument.width || camera.height() != instrument.height) {
    const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
    return Problem{Exit::kInput, "the camera's images have another size than its calibration",
                   config.camera->kind + ":" + config.camera->argument, size(instrument.width, instrument.height),
                   size(camera.width(), camera.height()), "use the calibration of this camera and mode"};
  }

  std::fputs(camera.summary().c_str(), stderr);

  std::unique_ptr<Transmitter> transmitter;
  if (!config.host.empty()) {
    auto address = Address::parse(config.host, config.file.string());
    if (!address) return address.error();
    TransmitterOptions options;
    options.host = *address;
    options.sender.from = proto::BootId{*proto::NodeId::make(config.node_id), random_boot()};
    options.sender.ring_frames = config.ring_frames;
    options.sender.ring_bytes = config.ring_frames * 600;  // a frame of 12 parameters takes 450 bytes
    options.sender.overwrite = camera.live();
    auto made = Transmitter::start(options);
    if (!made) return made.error();
    transmitter = std::move(made).value();
  }

  const std::atomic<bool>& cancelled = stop;
  FrameLoop loop(camera, *instrument.tracker, {frames, instrument.refractive_index, instrument.deadline.get()},
                 [&](const proto::CoefficientFrame& record) {
                   if (!transmitter) return true;
                   return camera.live() ? transmitter->push(record) : transmitter->push_waiting(record, cancelled);
                 });
  const auto begin = Clock::now();
  std::thread capture([&] { loop.capture(); });
  std::thread process([&] { loop.process(); });
  std::thread watch([&, next = begin + kStatusInterval, status = StatusMaker{}]() mutable {
    while (loop.capturing()) {
      std::this_thread::sleep_for(kWatchInterval);
      if (stop.load(std::memory_order_relaxed)) loop.stop();
      if (transmitter && Clock::now() >= next) {
        transmitter->set_status(status.make(loop.counters(), 1, false));
        next += kStatusInterval;
      }
    }
  });
  capture.join();
  process.join();
  watch.join();
  camera.stop();

  RunReport report;
  const FrameCounters& counters = loop.counters();
  report.captured = value(counters.captured);
  report.records = value(counters.records);
  report.surfaces = value(counters.surfaces);
  report.acquired = value(counters.acquired);
  report.lost_tracks = value(counters.lost_tracks);
  report.dropped_by_source = value(counters.dropped_by_source);
  report.dropped_late = value(counters.dropped_late);
  report.bad = value(counters.bad);
  report.hurried = value(counters.hurried);
  report.singular = value(counters.singular);
  report.singular_why = rank_text(loop.last_singular(), instrument.tracker->model().modes);
  report.disconnects = value(counters.disconnects);
  report.camera_faults = camera.faults().text();
  report.camera_last_words = camera.last_words();
  report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (transmitter) {
    report.sent = true;
    transmitter->set_status(StatusMaker{}.make(counters, std::max(report.seconds, 1e-3), true));
    report.transmitter = transmitter->finish();
  }
  return report;
}

std::string RunReport::text() const {
  std::ostringstream out;
  out.precision(4);
  out << "frames    " << captured << " captured, " << records << " records, " << surfaces << " with a surface, in "
      << seconds << " s\n"
      << "tracking  found " << acquired << " times, lost " << lost_tracks << " times\n"
      << "dropped   " << dropped_by_source << " by the source, " << dropped_late << " late, " << bad << " unusable\n";
  if (!camera_faults.empty()) out << "camera    " << camera_faults << "\n";
  out << camera_last_words;
  if (hurried > 0) out << "deadline  ended the fit of " << hurried << " frames\n";
  if (singular > 0) out << "singular  " << singular << " frames: " << singular_why << "\n";
  if (sent)
    out << "sent      " << transmitter.counts.datagrams << " datagrams, " << transmitter.counts.resent << " again, "
        << transmitter.counts.lost << " frames lost, " << transmitter.unacknowledged << " not acknowledged\n";
  return out.str();
}

}  // namespace srd::firmware
