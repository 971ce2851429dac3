// SPDX-License-Identifier: Apache-2.0
// What is said on the wire, as plain structs of fixed capacity. Units, bounds and meaning of each: proto/srd.proto.
#pragma once

#include <cstdint>
#include <limits>
#include <variant>

#include "dsp/core/time.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/optics/media.hpp"
#include "dsp/optics/surface_model.hpp"
#include "proto/identity.hpp"
#include "proto/information.hpp"
#include "proto/inplace.hpp"
#include "proto/key.hpp"

namespace srd::proto {

// What became of a frame. Numbers are on the wire, words in coefficient files: never reuse one (8 was "dropped").
enum class FrameStatus : std::uint8_t {
  kOk = 0,             // a surface from a tracked pattern
  kSearching = 1,      // no pattern found yet
  kLost = 2,           // the pattern was tracked and is gone
  kBadFrame = 3,       // the image could not be read
  kTooFewCorners = 4,  // fewer than the model needs
  kNotConverged = 5,   // the solver used up its steps or its time; the surface, when there, is its best so far
  kFailed = 6,         // the solver found no surface
  kAmbiguous = 7,      // two placements of the pattern fit equally well
  kDark = 9,           // a frame without light, on purpose
  kPoorFit = 10,       // a surface was fitted, but its corners disagree with it: another identity, or beyond the model
  kInconsistent = 11,  // a surface was fitted, but its corners contradict each other far more than they do as a rule
  kInterlaced = 12,    // a surface was fitted, but the image's even and odd rows are of two moments
};
inline constexpr int kFrameStatusCount = 13;  // numbers, 8 among them
[[nodiscard]] const char* to_string(FrameStatus status);

enum class NodeState : std::uint8_t { kStarting = 0, kSearching = 1, kTracking = 2, kLost = 3, kStopping = 4 };
inline constexpr int kNodeStateCount = 5;
[[nodiscard]] const char* to_string(NodeState state);

// Bits of NodeStatus::throttled, as the Raspberry Pi's firmware numbers them.
struct Throttled {
  static constexpr std::uint32_t kUnderVoltage = 1, kCapped = 2, kThrottled = 4, kTemperatureLimit = 8;
  static constexpr std::uint32_t kNow = 0xF, kAll = 0xF000F;
  static constexpr int kEverShift = 16;
};
// The worst that happens now: "under-voltage", "throttled", ..; "" when nothing does.
[[nodiscard]] const char* throttled_text(std::uint32_t throttled);

enum class ClockState : std::uint8_t { kUnknown = 0, kSynchronised = 1, kUnsynchronised = 2 };
enum class RecordState : std::uint8_t { kNone = 0, kRecording = 1, kStopped = 2 };

// One moment by two clocks.
struct Stamp {
  std::int64_t sensor_time_ns = 0;
  ClockId clock = ClockId::kUnknown;
  std::int64_t wall_time_ns = 0;          // since 1970 UTC; 0: not known
  std::uint64_t wall_uncertainty_ns = 0;  // one standard deviation; 0: not known
  friend constexpr bool operator==(const Stamp&, const Stamp&) = default;
};

// What every datagram of a node says first.
struct NodeHeader {
  BootId from;
  std::uint64_t sequence = 0;     // of the frame; in a status, of the next frame
  std::uint64_t oldest_held = 0;  // frames below can no longer be sent again
  friend constexpr bool operator==(const NodeHeader&, const NodeHeader&) = default;
};

// What the errors of calibration and pose leave alike in every frame. Travels as half floats: 1 part in 2000.
struct SystematicErrors {
  dsp::Coefficients<float> deviation;  // of each coefficient, mm, to kMost; empty: not known
  float height_mm = 0;                 // deviation of the height at the pattern's centre
  // Dates of the files that they come from, in every record of a node that states any: days since 1970 UTC, 0 not known.
  std::optional<std::uint32_t> pose_day{};
  std::optional<std::uint32_t> calibration_day{};       // none: the calibration's errors are not in it
  static constexpr float kMost = 60000;                 // mm: a half float ends at 65504
  static constexpr std::uint32_t kLastDay = 2'932'896;  // 9999-12-31
};

// One record a frame, with a surface or the reason why there is none.
struct CoefficientFrame {
  Stamp stamp;  // middle of the light that made the image
  FrameStatus status = FrameStatus::kSearching;
  dsp::SurfaceModel<float> model;                        // always; at least one mode
  float refractive_index = 1;                            // of the water, 1 to 2
  FixedList<dsp::Layer<float>, dsp::kMaxLayers> plates;  // on the pattern, from the top down
  float centre_x_mm = 0, centre_y_mm = 0;                // of the pattern
  float pattern_x_mm = 0, pattern_y_mm = 0;              // its size along X and Y; 0: not known
  dsp::Coefficients<float> coefficients;                 // mm; empty: no surface
  InformationFactor information;                         // size 0: not known
  SystematicErrors systematic;
  dsp::Metric metric = dsp::Metric::kReprojection;
  float mean_error = 0;  // in the metric's unit
  float reprojection_rms_px = 0;
  dsp::Stop stop = dsp::Stop::kTooFewCorners;
  bool at_bound = false;
  std::uint32_t iterations = 0;
  std::uint32_t corners_expected = 0, corners_found = 0, corners_used = 0;
  std::uint32_t exposure_us = 0;  // 0: not known
  StrobePhase strobe = StrobePhase::kUnstrobed;
  std::uint32_t dropped_before = 0;   // frames without a record since the previous record
  std::uint64_t source_sequence = 0;  // the camera's number
  std::uint32_t detection_us = 0, estimation_us = 0, total_us = 0;

  [[nodiscard]] bool has_surface() const { return coefficients.size() > 0; }
};

struct NodeStatus {
  Stamp stamp;  // when it was made
  NodeState state = NodeState::kStarting;
  float capture_hz = 0, record_hz = 0;
  std::uint64_t dropped_by_source = 0, dropped_late = 0, dropped_bad = 0, dropped_transmit = 0;
  std::uint64_t lost = 0, resent = 0, held = 0;
  std::uint64_t strobe_late = 0;
  float temperature_c = std::numeric_limits<float>::quiet_NaN();  // NaN: not known
  std::optional<std::int64_t> clock_offset_ns;
  std::uint64_t clock_uncertainty_ns = 0;  // bound of the wall clock's error; 0: not known
  ClockState clock_state = ClockState::kUnknown;
  std::uint32_t throttled = 0;                       // Throttled bits
  std::uint32_t restarts = 0;                        // starts in a row that followed an abnormal end
  FixedText<95> last_end;                            // of the run before this one; empty: it ended as it should
  std::uint64_t minor_faults = 0, major_faults = 0;  // page faults in the frame loop after its first frames
  RecordState recording = RecordState::kNone;
  std::uint64_t recorded = 0, record_dropped = 0;  // frames on the node's disk, and that it was too slow for
  std::uint64_t disconnects = 0;                   // of the camera
  std::uint64_t bad_stamps = 0;                    // frames timed by their arrival: the driver's time was impossible
  FixedText<15> software;
  FixedList<SequenceRange, 16> lost_ranges;  // ascending, apart
};

// Asks the host for a session of a keyed link.
struct Hello {
  Stamp stamp;  // when the challenge was made
  Challenge challenge{};
};

using NodeContent = std::variant<CoefficientFrame, NodeStatus, Hello>;

struct NodeMessage {
  NodeHeader header;
  NodeContent content;
};

// Of one boot of one node.
struct Acknowledgement {
  BootId of;
  std::uint64_t session = 0;             // random, new at every start of the host
  std::uint64_t serial = 0;              // grows within the session
  std::uint64_t first_missing = 0;       // all below: in the host's record and flushed, or never to come
  std::uint64_t known_end = 0;           // the host knows what it has up to here; >= first_missing
  FixedList<SequenceRange, 40> missing;  // within [first_missing, known_end), ascending, apart
  friend bool operator==(const Acknowledgement&, const Acknowledgement&) = default;
};

// The host's answer to a hello.
struct Welcome {
  BootId of;
  std::uint64_t session = 0, serial = 0;  // as in Acknowledgement
  Challenge from_node{}, from_host{};     // the hello's, and the host's own
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

// Whether a message keeps every bound that srd.proto states: only such are sent, only such are accepted.
[[nodiscard]] bool valid(const NodeHeader& header);
[[nodiscard]] bool valid(const CoefficientFrame& frame);
[[nodiscard]] bool valid(const NodeStatus& status);
[[nodiscard]] bool valid(const Hello& hello);
[[nodiscard]] bool valid(const Acknowledgement& acknowledgement);

}  // namespace srd::proto
