// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/run.hpp"

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/support/rank_text.hpp"
#include "firmware/service/stop_signals.hpp"

namespace srd::firmware {

namespace {

constexpr auto kWatchInterval = std::chrono::milliseconds(20);
constexpr auto kStatusInterval = std::chrono::seconds(1);

// "12 searching, 3 dark", the commonest first, and what the image tells.
std::string why_no_surface(const FrameLoop& loop) {
  std::vector<std::pair<std::uint64_t, int>> counts;
  for (int i = 0; i < proto::kFrameStatusCount; ++i)
    if (const std::uint64_t n = loop.statuses()[static_cast<std::size_t>(i)]; n > 0) counts.emplace_back(n, i);
  std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [n, status] : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(n) + " " + proto::to_string(static_cast<proto::FrameStatus>(status));
  const std::string image = loop.first_image().diagnosis();
  return image.empty() ? text : text + "; " + image;
}

}  // namespace

NodeRun::NodeRun(Instrument& instrument, StartedNode node, const RunOptions& options, Realtime& realtime,
                 const std::atomic<bool>& stop)
    : instrument_(instrument),
      camera_(*instrument.camera),
      options_(options),
      realtime_(realtime),
      stop_(stop),
      node_(std::move(node)),
      loop_(
          camera_, *instrument.tracker, loop_options(),
          [to = node_.transmitter.get()](const proto::CoefficientFrame& record) { return to == nullptr || to->push(record); }),
      watchdog_(service_.watchdog_ns(), node_.period_ns),
      notices_(options.notify),
      status_(options.version, options.restart),
      entered_(node_.strobe ? 3 : 2) {}

FrameLoopOptions NodeRun::loop_options() const {
  FrameLoopOptions options;
  options.frames = options_.frames;
  options.deadline = instrument_.deadline.get();
  options.doubts = instrument_.doubts.get();
  if (FrameRecorder* recorder = node_.recording.recorder.get(); recorder != nullptr)
    options.on_frame = [recorder, wait = !camera_.live()](const CameraFrame& frame) { recorder->take(frame, wait); };
  options.light = node_.strobe.get();
  return options;
}

void NodeRun::measure() {
  begin_ = next_status_ = Clock::now();
  auto blocked = std::make_optional<StopSignalsBlocked>();
  std::thread capture([this] {
    realtime_.enter(ThreadRole::kCapture);
    entered_.count_down();
    loop_.capture();
    running_.fetch_sub(1, std::memory_order_release);
  });
  std::thread process([this] {
    realtime_.enter(ThreadRole::kProcess);
    entered_.count_down();
    loop_.process();
    running_.fetch_sub(1, std::memory_order_release);
  });
  if (node_.strobe)
    node_.strobe->start([this] {
      realtime_.enter(ThreadRole::kStrobe);
      entered_.count_down();
    });
  blocked.reset();
  entered_.wait();
  realtime_.lock();
  service_.ready();
  if (const std::string notes = realtime_.notes(); !notes.empty()) options_.notify(notes);
  while (running_.load(std::memory_order_acquire) > 0) {
    watch();
    std::this_thread::sleep_for(kWatchInterval);
  }
  capture.join();
  process.join();
  if (node_.strobe) node_.strobe->stop();
  service_.stopping();
  camera_.stop();
  if (node_.recording.recorder) node_.recording.recorder->finish();
  notices_.watch_recorder(node_.recording.recorder.get());
  notices_.watch_stamps(camera_);
}

RunReport NodeRun::report() {
  RunReport report;
  const FrameCounters& counters = loop_.counters();
  report.captured = value_of(counters.captured);
  report.records = value_of(counters.records);
  report.surfaces = value_of(counters.surfaces);
  report.acquired = value_of(counters.acquired);
  report.lost_tracks = value_of(counters.lost_tracks);
  if (report.records > 0 && report.surfaces == 0) report.without_surface = why_no_surface(loop_);
  report.dropped_by_source = value_of(counters.dropped_by_source);
  report.dropped_late = value_of(counters.dropped_late);
  report.dropped_transmit = value_of(counters.dropped_transmit);
  report.bad = value_of(counters.bad);
  report.hurried = value_of(counters.hurried);
  report.singular = value_of(counters.singular);
  report.singular_why = rank_text(loop_.last_singular(), instrument_.tracker->model().modes);
  report.disconnects = value_of(counters.disconnects);
  report.camera_faults = camera_.faults().text();
  report.camera_last_words = camera_.last_words();
  report.minor_faults = loop_.capture_faults().minor() + loop_.process_faults().minor();
  report.major_faults = loop_.capture_faults().major() + loop_.process_faults().major();
  report.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (node_.strobe) report.strobe = node_.strobe->report();
  report.recording = !node_.recording.folder.empty();
  report.recorded_to = node_.recording.folder.string();
  report.record_problem = node_.recording.refusal;
  if (const FrameRecorder* recorder = node_.recording.recorder.get(); recorder != nullptr) {
    report.recorded = recorder->recorded();
    report.record_dropped = recorder->dropped();
    report.record_problem = recorder->problem();
  }
  if (node_.transmitter) {
    report.sent = true;
    StatusMaker whole_run(options_.version, options_.restart);
    node_.transmitter->set_status(status_by(whole_run, std::max(report.seconds, 1e-3), true));
    report.transmitter = node_.transmitter->finish();
  }
  return report;
}

proto::NodeStatus NodeRun::status_by(StatusMaker& maker, double seconds, bool stopping) const {
  const StrobeCounters* strobe = node_.strobe ? &node_.strobe->counters() : nullptr;
  proto::NodeStatus status = maker.make(loop_, node_.recording.recorder.get(), strobe, seconds, stopping);
  if (!node_.recording.refusal.empty()) status.recording = proto::RecordState::kStopped;
  return status;
}

void NodeRun::watch() {
  if (stop_.load(std::memory_order_relaxed)) loop_.stop();
  const Clock::time_point now = Clock::now();
  const FrameCounters& counters = loop_.counters();
  FrameWatchdog::Progress progress;
  progress.frames = value_of(counters.records) + value_of(counters.dropped_late);
  const std::uint64_t captured = value_of(counters.captured);
  progress.pending = captured - std::min(captured, progress.frames);
  progress.calls = value_of(counters.calls);
  progress.disconnected = counters.disconnected.load(std::memory_order_relaxed);
  if (watchdog_.due(now.time_since_epoch() / std::chrono::nanoseconds(1), progress)) service_.alive();
  if (now < next_status_) return;
  next_status_ += kStatusInterval;
  notices_.watch_recorder(node_.recording.recorder.get());
  notices_.watch_stamps(camera_);
  if (node_.transmitter && now - begin_ >= kStatusInterval) notices_.watch_host(*node_.transmitter);
  report_status(progress.disconnected);
}

void NodeRun::report_status(bool camera_disconnected) {
  const proto::NodeStatus status = status_by(status_, 1, false);
  const bool host_unresolved = node_.transmitter && !node_.transmitter->host_problem().empty();
  service_.status(status_text(status, camera_disconnected, host_unresolved));
  if (node_.transmitter) node_.transmitter->set_status(status);
}

}  // namespace srd::firmware
