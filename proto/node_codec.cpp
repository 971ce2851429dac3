// SPDX-License-Identifier: Apache-2.0
#include "proto/node_codec.hpp"

#include <pb_decode.h>
#include <pb_encode.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/ending.hpp"
#include "proto/half_float.hpp"
#include "proto/mode_code.hpp"
#include "srd.pb.h"

namespace srd::proto {
namespace {

constexpr std::uint8_t kOldestHeldTag = srd_wire_NodeDatagram_oldest_held_tag << 3;  // varint

template <class Bytes>
void copy_text(std::string_view text, Bytes& out) {
  out.size = static_cast<pb_size_t>(std::min(text.size(), sizeof(out.bytes)));
  std::memcpy(out.bytes, text.data(), out.size);
}

srd_wire_NodeDatagram start(const BootId& from, std::uint64_t sequence, const Stamp& stamp) {
  srd_wire_NodeDatagram datagram = srd_wire_NodeDatagram_init_zero;
  datagram.version = kWireVersion;
  copy_text(from.node.view(), datagram.node);
  datagram.boot = from.boot;
  datagram.sequence = sequence;
  datagram.sensor_time_ns = stamp.sensor_time_ns;
  datagram.clock = static_cast<std::uint32_t>(stamp.clock);
  datagram.wall_time_ns = stamp.wall_time_ns;
  datagram.wall_uncertainty_ns = stamp.wall_uncertainty_ns;
  return datagram;
}

Result<std::size_t> write(const srd_wire_NodeDatagram& datagram, std::span<std::uint8_t> out) {
  pb_ostream_t stream = pb_ostream_from_buffer(out.data(), std::min(out.size(), kMaxEncoded));
  if (!pb_encode(&stream, srd_wire_NodeDatagram_fields, &datagram)) return Errc::kTooSmall;
  return stream.bytes_written;
}

void fill(const CoefficientFrame& from, srd_wire_SurfaceModel& to) {
  for (const dsp::Mode& mode : from.model.modes) to.modes.bytes[to.modes.size++] = mode_code(mode);
  to.lx_mm = from.model.lx;
  to.ly_mm = from.model.ly;
  to.x0_mm = from.model.x0;
  to.y0_mm = from.model.y0;
  to.refractive_index = from.refractive_index;
  for (const dsp::Layer<float>& plate : from.plates) {
    to.plate_mm[to.plate_mm_count++] = plate.thickness;
    to.plate_index[to.plate_index_count++] = plate.index;
  }
  to.centre_x_mm = from.centre_x_mm;
  to.centre_y_mm = from.centre_y_mm;
  to.pattern_x_mm = from.pattern_x_mm;
  to.pattern_y_mm = from.pattern_y_mm;
}

void fill(const InformationFactor& from, srd_wire_InformationFactor& to) {
  const auto columns = static_cast<std::size_t>(from.size);
  std::copy_n(from.scale.begin(), columns, to.scale);
  to.scale_count = static_cast<pb_size_t>(columns);
  const auto entries = static_cast<std::size_t>(InformationFactor::entry_count(from.size));
  for (std::size_t i = 0; i < entries; ++i) {
    const auto bits = static_cast<std::uint16_t>(from.entries[i]);
    to.entries.bytes[2 * i] = static_cast<std::uint8_t>(bits & 0xFF);
    to.entries.bytes[2 * i + 1] = static_cast<std::uint8_t>(bits >> 8);
  }
  to.entries.size = static_cast<pb_size_t>(2 * entries);
}

void fill(const SystematicErrors& from, srd_wire_CoefficientFrame& to) {
  to.has_pose_day = from.pose_day.has_value();
  to.pose_day = from.pose_day.value_or(0);
  to.has_calibration_day = from.calibration_day.has_value();
  to.calibration_day = from.calibration_day.value_or(0);
  if (from.deviation.size() == 0) return;
  const auto put = [&to](float mm) {
    const std::uint16_t bits = half_of(mm);
    to.systematic.bytes[to.systematic.size++] = static_cast<std::uint8_t>(bits & 0xFF);
    to.systematic.bytes[to.systematic.size++] = static_cast<std::uint8_t>(bits >> 8);
  };
  for (const float mm : from.deviation) put(mm);
  put(from.height_mm);
}

void fill(const CoefficientFrame& from, srd_wire_CoefficientFrame& to) {
  to.status = static_cast<std::uint32_t>(from.status);
  to.has_model = true;
  fill(from, to.model);
  const auto coefficients = static_cast<std::size_t>(from.coefficients.size());
  std::copy_n(from.coefficients.data(), coefficients, to.coefficients);
  to.coefficients_count = static_cast<pb_size_t>(coefficients);
  to.has_information = from.information.size > 0;
  if (to.has_information) fill(from.information, to.information);
  to.metric = static_cast<std::uint32_t>(from.metric);
  to.mean_error = from.mean_error;
  to.reprojection_rms_px = from.reprojection_rms_px;
  to.stop = static_cast<std::uint32_t>(from.stop);
  to.at_bound = from.at_bound;
  to.iterations = from.iterations;
  to.corners_expected = from.corners_expected;
  to.corners_found = from.corners_found;
  to.corners_used = from.corners_used;
  to.exposure_us = from.exposure_us;
  to.strobe = static_cast<std::uint32_t>(from.strobe);
  to.dropped_before = from.dropped_before;
  to.source_sequence = from.source_sequence;
  to.detection_us = from.detection_us;
  to.estimation_us = from.estimation_us;
  to.total_us = from.total_us;
  fill(from.systematic, to);
}

void fill(const NodeStatus& from, srd_wire_NodeStatus& to) {
  to.state = static_cast<std::uint32_t>(from.state);
  to.capture_hz = from.capture_hz;
  to.record_hz = from.record_hz;
  to.dropped_by_source = from.dropped_by_source;
  to.dropped_late = from.dropped_late;
  to.dropped_bad = from.dropped_bad;
  to.dropped_transmit = from.dropped_transmit;
  to.lost = from.lost;
  to.resent = from.resent;
  to.held = from.held;
  to.strobe_late = from.strobe_late;
  to.has_temperature_c = !std::isnan(from.temperature_c);
  to.temperature_c = to.has_temperature_c ? from.temperature_c : 0;
  to.has_clock_offset_ns = from.clock_offset_ns.has_value();
  to.clock_offset_ns = from.clock_offset_ns.value_or(0);
  to.clock_uncertainty_ns = from.clock_uncertainty_ns;
  copy_text(from.software.view(), to.software);
  to.clock_state = static_cast<std::uint32_t>(from.clock_state);
  to.throttled = from.throttled;
  to.restarts = from.restarts;
  copy_text(from.last_end.view(), to.last_end);
  to.minor_faults = from.minor_faults;
  to.major_faults = from.major_faults;
  to.recording = static_cast<std::uint32_t>(from.recording);
  to.recorded = from.recorded;
  to.record_dropped = from.record_dropped;
  to.disconnects = from.disconnects;
  to.bad_stamps = from.bad_stamps;
  for (const SequenceRange& range : from.lost_ranges) to.lost_ranges[to.lost_ranges_count++] = {range.begin, range.end};
}

template <class Bytes>
void fill(const Challenge& from, Bytes& to) {
  to.size = static_cast<pb_size_t>(from.size());
  std::copy(from.begin(), from.end(), to.bytes);
}

template <class Bytes>
bool take(const Bytes& from, Challenge& to) {
  if (from.size != to.size()) return false;
  std::copy_n(from.bytes, to.size(), to.begin());
  return true;
}

struct FromHost {
  srd_wire_HostDatagram wire = srd_wire_HostDatagram_init_zero;
  BootId of;
};

// A whole datagram from a host with this content.
std::optional<FromHost> read(std::span<const std::uint8_t> datagram, const Key* key, pb_size_t content) {
  if (datagram.size() > kMaxDatagram) return std::nullopt;
  const auto message = without_end(key, Direction::kFromHost, datagram);
  if (!message) return std::nullopt;
  FromHost out;
  pb_istream_t stream = pb_istream_from_buffer(message->data(), message->size());
  if (!pb_decode(&stream, srd_wire_HostDatagram_fields, &out.wire) || out.wire.version != kWireVersion ||
      out.wire.which_content != content)
    return std::nullopt;
  const auto node = NodeId::make({reinterpret_cast<const char*>(out.wire.node.bytes), out.wire.node.size});
  if (!node) return std::nullopt;
  out.of = {*node, out.wire.boot};
  return out;
}

}  // namespace

Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const CoefficientFrame& frame,
                           std::span<std::uint8_t> out) {
  if (!valid(NodeHeader{from, sequence, 0}) || !valid(frame)) return Errc::kInvalidArgument;
  srd_wire_NodeDatagram datagram = start(from, sequence, frame.stamp);
  datagram.which_content = srd_wire_NodeDatagram_frame_tag;
  datagram.content.frame = srd_wire_CoefficientFrame_init_zero;
  fill(frame, datagram.content.frame);
  return write(datagram, out);
}

std::size_t most_frame_bytes(const dsp::ModeList& modes) {
  constexpr std::array<char, NodeId::kMaxLength + 1> kLongest = [] {
    std::array<char, NodeId::kMaxLength + 1> name{};
    for (std::size_t i = 0; i < NodeId::kMaxLength; ++i) name[i] = 'n';
    return name;
  }();
  CoefficientFrame frame;
  frame.stamp = {-1, ClockId::kRecording, -1, ~std::uint64_t{0}};
  frame.status = FrameStatus::kInterlaced;
  frame.model = {modes, 1, 1, 1, 1};
  while (frame.plates.push({1, 1})) {}
  frame.centre_x_mm = frame.centre_y_mm = frame.pattern_x_mm = frame.pattern_y_mm = 1;
  frame.coefficients.setConstant(modes.size(), 1);
  frame.systematic.deviation.setConstant(modes.size(), 1);
  frame.systematic.pose_day = frame.systematic.calibration_day = SystematicErrors::kLastDay;
  frame.information.size = modes.size();
  frame.information.scale.fill(1);
  frame.information.entries.fill(1);
  frame.metric = dsp::Metric::kCollinearity;
  frame.mean_error = frame.reprojection_rms_px = 1;
  frame.stop = dsp::Stop::kOutOfDomain;
  frame.at_bound = true;
  frame.strobe = StrobePhase::kDark;
  frame.source_sequence = ~std::uint64_t{0};
  for (std::uint32_t* count :
       {&frame.iterations, &frame.corners_expected, &frame.corners_found, &frame.corners_used, &frame.exposure_us,
        &frame.dropped_before, &frame.detection_us, &frame.estimation_us, &frame.total_us})
    *count = ~std::uint32_t{0};
  std::array<std::uint8_t, kMaxEncoded> out;
  const auto bytes =
      encode({*NodeId::make({kLongest.data(), NodeId::kMaxLength}), ~std::uint64_t{0}}, kMaxSequence, frame, out);
  return bytes ? *bytes : kMaxEncoded;
}

Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const NodeStatus& status, std::span<std::uint8_t> out) {
  if (!valid(NodeHeader{from, sequence, 0}) || !valid(status)) return Errc::kInvalidArgument;
  srd_wire_NodeDatagram datagram = start(from, sequence, status.stamp);
  datagram.which_content = srd_wire_NodeDatagram_status_tag;
  datagram.content.status = srd_wire_NodeStatus_init_zero;
  fill(status, datagram.content.status);
  return write(datagram, out);
}

Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const Hello& hello, std::span<std::uint8_t> out) {
  if (!valid(NodeHeader{from, sequence, 0}) || !valid(hello)) return Errc::kInvalidArgument;
  srd_wire_NodeDatagram datagram = start(from, sequence, hello.stamp);
  datagram.which_content = srd_wire_NodeDatagram_hello_tag;
  datagram.content.hello = srd_wire_Hello_init_zero;
  fill(hello.challenge, datagram.content.hello.challenge);
  return write(datagram, out);
}

std::size_t seal(std::span<std::uint8_t> buffer, std::size_t encoded_bytes, std::uint64_t oldest_held, const Key* key) {
  std::size_t at = encoded_bytes;
  buffer[at++] = kOldestHeldTag;
  for (; oldest_held >= 0x80; oldest_held >>= 7) buffer[at++] = static_cast<std::uint8_t>(oldest_held | 0x80);
  buffer[at++] = static_cast<std::uint8_t>(oldest_held);
  return append_end(key, Direction::kFromNode, buffer, at);
}

std::optional<Acknowledgement> decode_acknowledgement(std::span<const std::uint8_t> datagram, const Key* key) {
  const auto heard = read(datagram, key, srd_wire_HostDatagram_acknowledgement_tag);
  if (!heard || heard->wire.content.acknowledgement.missing_count % 2 != 0) return std::nullopt;
  const srd_wire_Acknowledgement& content = heard->wire.content.acknowledgement;
  Acknowledgement out;
  out.of = heard->of;
  out.session = heard->wire.session;
  out.serial = heard->wire.serial;
  out.first_missing = content.first_missing;
  out.known_end = content.known_end;
  std::uint64_t at = content.first_missing;
  if (content.known_end > kMaxSequence || at > content.known_end) return std::nullopt;
  for (pb_size_t i = 0; i < content.missing_count; i += 2) {
    const std::uint64_t pass = content.missing[i], size = content.missing[i + 1];
    if (pass > content.known_end - at || size > content.known_end - at - pass) return std::nullopt;
    out.missing.push({at + pass, at + pass + size});
    at += pass + size;
  }
  if (!valid(out)) return std::nullopt;
  return out;
}

std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> datagram, const Key& of_node) {
  const auto heard = read(datagram, &of_node, srd_wire_HostDatagram_welcome_tag);
  if (!heard) return std::nullopt;
  const srd_wire_Welcome& content = heard->wire.content.welcome;
  Welcome out{.of = heard->of, .session = heard->wire.session, .serial = heard->wire.serial};
  if (!take(content.node_challenge, out.from_node) || !take(content.host_challenge, out.from_host)) return std::nullopt;
  return out;
}

}  // namespace srd::proto
