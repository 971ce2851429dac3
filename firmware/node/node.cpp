// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/node.hpp"
#include "firmware/config/strobe_factory.hpp"

#include <algorithm>
#include <chrono>
#include <latch>
#include <optional>
#include <random>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/support/rank_text.hpp"
#include "firmware/node/status_maker.hpp"
#include "firmware/realtime/realtime.hpp"
#include "firmware/recording/frame_recorder.hpp"
#include "firmware/service/notifier.hpp"
#include "firmware/service/stop_signals.hpp"
#include "firmware/service/watchdog.hpp"

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

Outcome<void> start_camera(const NodeConfig& config, Instrument& instrument) {
  Camera& camera = *instrument.camera;
  if (auto started = camera.start(); !started) return started.error();
  if (camera.width() == instrument.width && camera.height() == instrument.height) return {};
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return Problem{Exit::kInput,
                 "the camera's images have another size than its calibration",
                 config.camera->kind + ":" + config.camera->argument,
                 size(instrument.width, instrument.height),
                 size(camera.width(), camera.height()),
                 "use the calibration of this camera and mode"};
}

// None without a host.
Outcome<std::unique_ptr<Transmitter>> start_transmitter(const NodeConfig& config, const Camera& camera) {
  if (config.host.empty()) return std::unique_ptr<Transmitter>();
  TransmitterOptions options;
  options.host = config.host;
  options.sender.from = proto::BootId{*proto::NodeId::make(config.node_id), random_boot()};
  options.sender.ring_frames = config.ring_frames;
  options.sender.ring_bytes = config.ring_frames * 600;  // a frame of 12 parameters takes 450 bytes
  options.sender.overwrite = camera.live();
  return Transmitter::start(options);
}

Outcome<std::unique_ptr<FrameRecorder>> start_recorder(const NodeConfig& config, const Instrument& instrument) {
  std::error_code error;
  if (config.camera->kind == "recording" &&
      std::filesystem::equivalent(config.camera->argument, config.recording.folder, error))
    return Problem{
        Exit::kUsage, "a recording cannot be recorded over itself", config.recording.folder.string(), "another folder", "", ""};
  return FrameRecorder::start(config.recording, instrument.rig, instrument.camera->width(), instrument.camera->height());
}

struct RunRecording {
  std::filesystem::path folder;  // empty: none is asked for
  std::unique_ptr<FrameRecorder> recorder;
  std::string refusal;  // why there is no recorder for the folder
};

// A disk that takes no recording ends the run of a person who asked for one by hand. Where the file asks at every start the
// measurement goes on without, as it does when the disk fills up later.
Outcome<RunRecording> start_recording(const NodeConfig& config, const Instrument& instrument) {
  RunRecording recording{config.recording.folder, nullptr, {}};
  if (recording.folder.empty()) return recording;
  auto recorder = start_recorder(config, instrument);
  if (recorder) {
    recording.folder = (*recorder)->folder();
    recording.recorder = std::move(*recorder);
  } else {
    const Problem& problem = recorder.error();
    if (!config.recording.numbered_folders || problem.exit != Exit::kInput) return problem;
    recording.refusal = problem.what + ": " + problem.found;
    if (!problem.expected.empty()) recording.refusal += ", expected " + problem.expected;
  }
  return recording;
}

std::string text_of(const RunRecording& recording) {
  if (recording.folder.empty()) return {};
  if (recording.recorder) return "recording " + recording.folder.string() + "\n";
  return "note      nothing is recorded to " + recording.folder.string() + ": " + recording.refusal +
         "; the measurement goes on\n";
}

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

// A started camera, its frame loop in two threads, and this thread that watches them.
class NodeRun {
 public:
  // period_ns: between two frames, as FrameWatchdog has it.
  NodeRun(Instrument& instrument, const RunOptions& options, std::int64_t period_ns, std::unique_ptr<Transmitter> transmitter,
          RunRecording recording, std::unique_ptr<Strobe> strobe, Realtime& realtime, const std::atomic<bool>& stop)
      : camera_(*instrument.camera),
        tracker_(*instrument.tracker),
        options_(options),
        transmitter_(std::move(transmitter)),
        recording_(std::move(recording)),
        strobe_(std::move(strobe)),
        realtime_(realtime),
        stop_(stop),
        loop_(camera_, tracker_, {options.frames, instrument.refractive_index, instrument.deadline.get(), see(), strobe_.get()},
              [this](const proto::CoefficientFrame& record) { return deliver(record); }),
        watchdog_(service_.watchdog_ns(), period_ns) {}

  void measure() {
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
    if (strobe_)
      strobe_->start([this] {
        realtime_.enter(ThreadRole::kStrobe);
        entered_.count_down();
      });
    blocked.reset();
    entered_.wait();
    realtime_.lock();
    service_.ready();
    if (const std::string notes = realtime_.notes(); !notes.empty()) options_.say(notes);
    while (running_.load(std::memory_order_acquire) > 0) {
      watch();
      std::this_thread::sleep_for(kWatchInterval);
    }
    capture.join();
    process.join();
    if (strobe_) strobe_->stop();
    service_.stopping();
    camera_.stop();
    if (recording_.recorder) recording_.recorder->finish();
    watch_recorder();
    watch_stamps();
  }

  RunReport report() {
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
    report.bad = value_of(counters.bad);
    report.hurried = value_of(counters.hurried);
    report.singular = value_of(counters.singular);
    report.singular_why = rank_text(loop_.last_singular(), tracker_.model().modes);
    report.disconnects = value_of(counters.disconnects);
    report.camera_faults = camera_.faults().text();
    report.camera_last_words = camera_.last_words();
    report.minor_faults = loop_.capture_faults().minor() + loop_.process_faults().minor();
    report.major_faults = loop_.capture_faults().major() + loop_.process_faults().major();
    report.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (strobe_) report.strobe = strobe_->report();
    report.recording = !recording_.folder.empty();
    report.recorded_to = recording_.folder.string();
    report.record_problem = recording_.refusal;
    if (const FrameRecorder* recorder = recording_.recorder.get(); recorder != nullptr) {
      report.recorded = recorder->recorded();
      report.record_dropped = recorder->dropped();
      report.record_problem = recorder->problem();
    }
    if (transmitter_) {
      report.sent = true;
      StatusMaker whole_run(options_.version, options_.restart);
      transmitter_->set_status(status_by(whole_run, std::max(report.seconds, 1e-3), true));
      report.transmitter = transmitter_->finish();
    }
    return report;
  }

 private:
  using Clock = std::chrono::steady_clock;

  SeeFrame see() {
    if (!recording_.recorder) return {};
    return [to = recording_.recorder.get(), wait = !camera_.live()](const CameraFrame& frame) { to->take(frame, wait); };
  }

  // Said when it happens: nobody should learn it at the end.
  void watch_recorder() {
    const FrameRecorder* recorder = recording_.recorder.get();
    if (recorder == nullptr || !recorder->stopped() || said_stopped_) return;
    said_stopped_ = true;
    options_.say("note      recording to " + recorder->folder().string() + " has stopped: " + recorder->problem() +
                 "; the measurement goes on\n");
  }

  // Once: how many it became is in the status and the report.
  void watch_stamps() {
    if (said_stamps_ || value_of(camera_.faults().bad_stamps) == 0) return;
    said_stamps_ = true;
    options_.say(
        "note      the camera's driver gives times that cannot be true (standing still, running back, or in the "
        "future): those frames carry the time at which they arrived\n");
  }

  proto::NodeStatus status_by(StatusMaker& maker, double seconds, bool stopping) {
    proto::NodeStatus status = maker.make(loop_, recording_.recorder.get(), strobe_.get(), seconds, stopping);
    if (!recording_.refusal.empty()) status.recording = proto::RecordState::kStopped;
    return status;
  }

  // Once for each change.
  void watch_host() {
    const std::string problem = transmitter_ ? transmitter_->host_problem() : std::string();
    if (const std::string address = transmitter_ ? transmitter_->host_address() : std::string(); address != said_address_) {
      said_address_ = address;
      options_.say("host      " + address + "\n");
    }
    if (problem.empty() == !host_missed_) return;
    host_missed_ = !problem.empty();
    options_.say(host_missed_ ? "note      " + problem + "; it is looked up every second, and frames are kept until then\n"
                              : std::string("host      has an address now\n"));
  }

  bool deliver(const proto::CoefficientFrame& record) {
    if (!transmitter_) return true;
    return camera_.live() ? transmitter_->push(record) : transmitter_->push_waiting(record, stop_);
  }

  void watch() {
    if (stop_.load(std::memory_order_relaxed)) loop_.stop();
    const Clock::time_point now = Clock::now();
    const FrameCounters& counters = loop_.counters();
    FrameWatchdog::Progress progress;
    progress.frames = value_of(counters.records) + value_of(counters.dropped_late);
    const std::uint64_t captured = value_of(counters.captured);
    progress.pending = captured - std::min(captured, progress.frames);
    progress.calls = value_of(counters.calls);
    progress.away = counters.away.load(std::memory_order_relaxed);
    if (watchdog_.due(now.time_since_epoch() / std::chrono::nanoseconds(1), progress)) service_.alive();
    if (now < next_status_) return;
    next_status_ += kStatusInterval;
    watch_recorder();
    watch_stamps();
    if (now - begin_ >= kStatusInterval) watch_host();  // a lookup takes its moment
    const proto::NodeStatus status = status_by(status_, 1, false);
    const bool host_unresolved = transmitter_ && !transmitter_->host_problem().empty();
    service_.status(status_text(status, progress.away, host_unresolved));
    if (transmitter_) transmitter_->set_status(status);
  }

  Camera& camera_;
  dsp::SurfaceTracker<float>& tracker_;
  const RunOptions& options_;
  std::unique_ptr<Transmitter> transmitter_;
  RunRecording recording_;
  std::unique_ptr<Strobe> strobe_;
  bool said_stopped_ = false;
  bool said_stamps_ = false;
  bool host_missed_ = false;  // and said so
  std::string said_address_;
  Realtime& realtime_;
  const std::atomic<bool>& stop_;
  FrameLoop loop_;
  ServiceNotifier service_;
  FrameWatchdog watchdog_;
  std::latch entered_{strobe_ ? 3 : 2};
  std::atomic<int> running_{2};
  StatusMaker status_{options_.version, options_.restart};
  Clock::time_point begin_, next_status_;
};

}  // namespace

Outcome<RunReport> run_node(const NodeConfig& config, Instrument& instrument, const RunOptions& options,
                            const std::atomic<bool>& stop) {
  Realtime realtime(config.realtime, instrument.camera->live());
  realtime.prepare();
  if (auto started = start_camera(config, instrument); !started) return started.error();
  options.say(instrument.camera->summary());
  auto transmitter = start_transmitter(config, *instrument.camera);
  if (!transmitter) return transmitter.error();
  auto recording = start_recording(config, instrument);
  if (!recording) return recording.error();
  if (const std::string lines = text_of(*recording); !lines.empty()) options.say(lines);
  auto strobe = open_strobe(config, *instrument.camera);
  if (!strobe) return strobe.error();
  const bool paced = instrument.camera->live() && !config.live.trigger_input && config.frame_rate_hz > 0;
  const std::int64_t period_ns = paced ? static_cast<std::int64_t>(1e9 / config.frame_rate_hz) : 0;
  NodeRun run(instrument, options, period_ns, std::move(*transmitter), std::move(*recording), std::move(*strobe), realtime,
              stop);
  run.measure();
  return run.report();
}

std::string RunReport::text() const {
  std::ostringstream out;
  out.precision(4);
  out << "frames    " << captured << " captured, " << records << " records, " << surfaces << " with a surface, in " << seconds
      << " s\n"
      << "tracking  found " << acquired << " times, lost " << lost_tracks << " times\n"
      << "dropped   " << dropped_by_source << " by the source, " << dropped_late << " late, " << bad << " unusable\n";
  if (!without_surface.empty()) out << "surface   none in any frame: " << without_surface << "\n";
  if (!camera_faults.empty()) out << "camera    " << camera_faults << "\n";
  out << camera_last_words;
  if (minor_faults + major_faults > 0)
    out << "memory    " << minor_faults << " page faults without the disk, " << major_faults
        << " with it, in the frame loop after its first frames\n";
  out << strobe.text();
  if (hurried > 0) out << "deadline  ended the fit of " << hurried << " frames\n";
  if (singular > 0) out << "singular  " << singular << " frames: " << singular_why << "\n";
  if (recording)
    out << "recorded  " << recorded << " frames to " << recorded_to << ", " << record_dropped << " dropped"
        << (record_problem.empty() ? "" : "; stopped: " + record_problem) << "\n";
  if (!transmitter.host_address.empty()) out << "host      " << transmitter.host_address << "\n";
  if (!transmitter.host_problem.empty()) out << "host      " << transmitter.host_problem << "\n";
  if (sent)
    out << "sent      " << transmitter.counts.datagrams << " datagrams, " << transmitter.counts.resent << " again, "
        << transmitter.counts.lost << " frames lost, " << transmitter.unacknowledged << " not acknowledged\n";
  return out.str();
}

}  // namespace srd::firmware
