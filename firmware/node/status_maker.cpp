// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/status_maker.hpp"

#include <cmath>
#include <sstream>

namespace srd::firmware {

StatusMaker::StatusMaker(std::string_view version, const Restart& restart, const HealthSources& sources)
    : health_(sources.root), read_clock_(sources.clock) {
  using Software = decltype(constant_.software);
  using EndText = decltype(constant_.last_end);
  constant_.software = Software::make(version.substr(0, Software::kCapacity)).value_or(Software{});
  constant_.last_end = EndText::make(std::string_view(restart.last_end).substr(0, EndText::kCapacity)).value_or(EndText{});
  constant_.restarts = restart.restarts;
}

proto::NodeStatus StatusMaker::make(const FrameLoop& loop, const FrameRecorder* recorder, const StrobeCounters* strobe,
                                    double seconds, bool stopping) {
  const FrameCounters& counters = loop.counters();
  proto::NodeStatus status = constant_;
  status.state =
      stopping ? proto::NodeState::kStopping : static_cast<proto::NodeState>(counters.state.load(std::memory_order_relaxed));
  const std::uint64_t captured = value_of(counters.captured), records = value_of(counters.records);
  status.capture_hz = static_cast<float>(static_cast<double>(captured - captured_) / seconds);
  status.record_hz = static_cast<float>(static_cast<double>(records - records_) / seconds);
  captured_ = captured;
  records_ = records;
  status.dropped_by_source = value_of(counters.dropped_by_source);
  status.dropped_late = value_of(counters.dropped_late);
  status.dropped_bad = value_of(counters.bad);
  status.dropped_transmit = value_of(counters.dropped_transmit);
  status.disconnects = value_of(counters.disconnects);
  status.minor_faults = loop.capture_faults().minor() + loop.process_faults().minor();
  status.major_faults = loop.capture_faults().major() + loop.process_faults().major();
  status.bad_stamps = value_of(loop.camera_faults().bad_stamps);
  if (strobe != nullptr) status.strobe_late = value_of(strobe->late);
  if (recorder != nullptr) {
    status.recording = recorder->stopped() ? proto::RecordState::kStopped : proto::RecordState::kRecording;
    status.recorded = recorder->recorded();
    status.record_dropped = recorder->dropped();
  }
  const HealthReading board = health_.read();
  status.temperature_c = board.temperature_c;
  status.throttled = board.throttled;
  const ClockHealth clock = read_clock_();
  status.clock_state = clock.state;
  status.clock_offset_ns = clock.offset_ns;
  status.clock_uncertainty_ns = clock.uncertainty_ns;
  return status;
}

std::string status_text(const proto::NodeStatus& status, bool camera_disconnected, bool host_unresolved) {
  std::ostringstream out;
  out.precision(3);
  out << (camera_disconnected ? "camera is away, being called" : proto::to_string(status.state)) << ", " << status.capture_hz
      << " frames/s, dropped " << status.dropped_by_source << " by the source, " << status.dropped_late << " late";
  if (host_unresolved) out << ", the host's name has no address yet";
  if (std::isfinite(status.temperature_c)) out << ", " << status.temperature_c << " C";
  if ((status.throttled & proto::Throttled::kNow) != 0) out << ", " << proto::throttled_text(status.throttled);
  if (status.strobe_late > 0) out << ", " << status.strobe_late << " pulses late";
  if (status.recording == proto::RecordState::kRecording) out << ", " << status.recorded << " frames recorded";
  if (status.recording == proto::RecordState::kStopped) out << ", recording stopped";
  return out.str();
}

}  // namespace srd::firmware
