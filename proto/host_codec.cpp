// SPDX-License-Identifier: Apache-2.0
#include "proto/host_codec.hpp"

#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "proto/ending.hpp"
#include "proto/half_float.hpp"
#include "proto/mode_code.hpp"
#include "srd.pb.h"

namespace srd::proto {
namespace {

// An enumerator by its number on the wire; bounds are checked by valid().
template <class Enum>
std::optional<Enum> enumerator(std::uint32_t number) {
  if (number > std::numeric_limits<std::uint8_t>::max()) return std::nullopt;
  return static_cast<Enum>(number);
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

bool read(const wire::InformationFactor& from, InformationFactor& to) {
  if (from.scale_size() == 0 || from.scale_size() > dsp::kMaxModes) return false;
  to.size = from.scale_size();
  const auto entries = static_cast<std::size_t>(InformationFactor::entry_count(to.size));
  const auto bytes = bytes_of(from.entries());
  if (bytes.size() != 2 * entries) return false;
  for (int j = 0; j < to.size; ++j) to.scale[static_cast<std::size_t>(j)] = from.scale(j);
  for (std::size_t i = 0; i < entries; ++i)
    to.entries[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[2 * i] | (bytes[2 * i + 1] << 8)));
  return true;
}

bool read(const wire::CoefficientFrame& from, SystematicErrors& to) {
  if (from.has_pose_day()) to.pose_day = from.pose_day();
  if (from.has_calibration_day()) to.calibration_day = from.calibration_day();
  const auto bytes = bytes_of(from.systematic());
  if (bytes.empty()) return true;
  if (bytes.size() % 2 != 0 || bytes.size() / 2 != static_cast<std::size_t>(from.coefficients_size()) + 1) return false;
  const auto number = [&](int i) {
    const auto at = static_cast<std::size_t>(2 * i);
    return float_of(static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8)));
  };
  to.deviation.resize(from.coefficients_size());
  for (int i = 0; i < from.coefficients_size(); ++i) to.deviation[i] = number(i);
  to.height_mm = number(from.coefficients_size());
  return true;
}

std::optional<CoefficientFrame> read(const wire::CoefficientFrame& from, const Stamp& stamp) {
  CoefficientFrame to;
  to.stamp = stamp;
  const auto status = enumerator<FrameStatus>(from.status());
  const auto metric = enumerator<dsp::Metric>(from.metric());
  const auto stop = enumerator<dsp::Stop>(from.stop());
  const auto strobe = enumerator<StrobePhase>(from.strobe());
  const auto modes = mode_list(bytes_of(from.model().modes()));
  if (!status || !metric || !stop || !strobe || !modes.ok() || from.coefficients_size() > dsp::kMaxModes) return std::nullopt;
  to.status = *status;
  to.metric = *metric;
  to.stop = *stop;
  to.strobe = *strobe;
  const wire::SurfaceModel& model = from.model();
  to.model = {*modes, model.lx_mm(), model.ly_mm(), model.x0_mm(), model.y0_mm()};
  to.refractive_index = model.refractive_index();
  if (model.plate_mm_size() != model.plate_index_size()) return std::nullopt;
  for (int i = 0; i < model.plate_mm_size(); ++i)
    if (!to.plates.push({model.plate_mm(i), model.plate_index(i)})) return std::nullopt;
  to.centre_x_mm = model.centre_x_mm();
  to.centre_y_mm = model.centre_y_mm();
  to.pattern_x_mm = model.pattern_x_mm();
  to.pattern_y_mm = model.pattern_y_mm();
  to.coefficients.resize(from.coefficients_size());
  for (int i = 0; i < from.coefficients_size(); ++i) to.coefficients[i] = from.coefficients(i);
  if (from.has_information() && !read(from.information(), to.information)) return std::nullopt;
  if (!read(from, to.systematic)) return std::nullopt;
  to.mean_error = from.mean_error();
  to.reprojection_rms_px = from.reprojection_rms_px();
  to.at_bound = from.at_bound();
  to.iterations = from.iterations();
  to.corners_expected = from.corners_expected();
  to.corners_found = from.corners_found();
  to.corners_used = from.corners_used();
  to.exposure_us = from.exposure_us();
  to.dropped_before = from.dropped_before();
  to.source_sequence = from.source_sequence();
  to.detection_us = from.detection_us();
  to.estimation_us = from.estimation_us();
  to.total_us = from.total_us();
  if (!valid(to)) return std::nullopt;
  return to;
}

std::optional<NodeStatus> read(const wire::NodeStatus& from, const Stamp& stamp) {
  NodeStatus to;
  to.stamp = stamp;
  const auto state = enumerator<NodeState>(from.state());
  const auto software = FixedText<15>::make(from.software());
  const auto last_end = FixedText<95>::make(from.last_end());
  const auto clock_state = enumerator<ClockState>(from.clock_state());
  const auto recording = enumerator<RecordState>(from.recording());
  if (!state || !software || !last_end || !clock_state || !recording) return std::nullopt;
  to.last_end = *last_end;
  to.clock_state = *clock_state;
  to.recording = *recording;
  to.throttled = from.throttled();
  to.restarts = from.restarts();
  to.minor_faults = from.minor_faults();
  to.major_faults = from.major_faults();
  to.recorded = from.recorded();
  to.record_dropped = from.record_dropped();
  to.disconnects = from.disconnects();
  to.bad_stamps = from.bad_stamps();
  to.state = *state;
  to.software = *software;
  to.capture_hz = from.capture_hz();
  to.record_hz = from.record_hz();
  to.dropped_by_source = from.dropped_by_source();
  to.dropped_late = from.dropped_late();
  to.dropped_bad = from.dropped_bad();
  to.dropped_transmit = from.dropped_transmit();
  to.lost = from.lost();
  to.resent = from.resent();
  to.held = from.held();
  to.strobe_late = from.strobe_late();
  if (from.has_temperature_c()) {
    if (!std::isfinite(from.temperature_c())) return std::nullopt;
    to.temperature_c = from.temperature_c();
  }
  if (from.has_clock_offset_ns()) to.clock_offset_ns = from.clock_offset_ns();
  to.clock_uncertainty_ns = from.clock_uncertainty_ns();
  for (const wire::SequenceRange& range : from.lost_ranges())
    if (!to.lost_ranges.push({range.begin(), range.end()})) return std::nullopt;
  if (!valid(to)) return std::nullopt;
  return to;
}

std::optional<Hello> read(const wire::Hello& from, const Stamp& stamp) {
  Hello to;
  to.stamp = stamp;
  const auto bytes = bytes_of(from.challenge());
  if (bytes.size() != to.challenge.size()) return std::nullopt;
  std::copy(bytes.begin(), bytes.end(), to.challenge.begin());
  if (!valid(to)) return std::nullopt;
  return to;
}

wire::HostDatagram start(const BootId& of, std::uint64_t session, std::uint64_t serial) {
  wire::HostDatagram out;
  out.set_version(kWireVersion);
  out.set_node(std::string(of.node.view()));
  out.set_boot(of.boot);
  out.set_session(session);
  out.set_serial(serial);
  return out;
}

std::vector<std::uint8_t> ended(const wire::HostDatagram& message, const Key* key) {
  std::vector<std::uint8_t> datagram(message.ByteSizeLong() + end_bytes(key));
  const std::size_t bytes = datagram.size() - end_bytes(key);
  if (!message.SerializeToArray(datagram.data(), static_cast<int>(bytes))) return {};
  append_end(key, Direction::kFromHost, datagram, bytes);
  return datagram;
}

}  // namespace

std::optional<NodeMessage> decode_node_datagram(std::span<const std::uint8_t> datagram, const Key* key) {
  if (datagram.size() > kMaxDatagram) return std::nullopt;
  const auto message = without_end(key, Direction::kFromNode, datagram);
  return message ? decode_node_message(*message) : std::nullopt;
}

std::string record_schema() {
  google::protobuf::FileDescriptorSet set;
  wire::NodeDatagram::descriptor()->file()->CopyTo(set.add_file());
  return set.SerializeAsString();
}

std::optional<NodeMessage> decode_node_message(std::span<const std::uint8_t> message) {
  wire::NodeDatagram in;
  if (message.size() > kMaxDatagram || !in.ParseFromArray(message.data(), static_cast<int>(message.size())) ||
      in.version() != kWireVersion)
    return std::nullopt;
  const auto node = NodeId::make(in.node());
  const auto clock = enumerator<ClockId>(in.clock());
  if (!node || !clock) return std::nullopt;
  NodeMessage out{.header = {{*node, in.boot()}, in.sequence(), in.oldest_held()}, .content = NodeStatus{}};
  if (!valid(out.header)) return std::nullopt;
  const Stamp stamp{in.sensor_time_ns(), *clock, in.wall_time_ns(), in.wall_uncertainty_ns()};
  const auto take = [&out](const auto& content) {
    if (!content) return false;
    out.content = *content;
    return true;
  };
  bool taken = false;
  switch (in.content_case()) {
    case wire::NodeDatagram::kFrame: taken = take(read(in.frame(), stamp)); break;
    case wire::NodeDatagram::kStatus: taken = take(read(in.status(), stamp)); break;
    case wire::NodeDatagram::kHello: taken = take(read(in.hello(), stamp)); break;
    case wire::NodeDatagram::CONTENT_NOT_SET: break;
  }
  if (!taken) return std::nullopt;
  return out;
}

std::vector<std::uint8_t> encode_datagram(const Acknowledgement& acknowledgement, const Key* key) {
  if (!valid(acknowledgement)) return {};
  wire::HostDatagram out = start(acknowledgement.of, acknowledgement.session, acknowledgement.serial);
  wire::Acknowledgement& content = *out.mutable_acknowledgement();
  content.set_first_missing(acknowledgement.first_missing);
  content.set_known_end(acknowledgement.known_end);
  std::uint64_t at = acknowledgement.first_missing;
  for (const SequenceRange& range : acknowledgement.missing) {
    content.add_missing(range.begin - at);
    content.add_missing(range.size());
    at = range.end;
  }
  return ended(out, key);
}

std::vector<std::uint8_t> encode_datagram(const Welcome& welcome, const Key& of_node) {
  wire::HostDatagram out = start(welcome.of, welcome.session, welcome.serial);
  out.mutable_welcome()->set_node_challenge(welcome.from_node.data(), welcome.from_node.size());
  out.mutable_welcome()->set_host_challenge(welcome.from_host.data(), welcome.from_host.size());
  return ended(out, &of_node);
}

}  // namespace srd::proto
