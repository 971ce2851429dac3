// SPDX-License-Identifier: Apache-2.0
// What a run did, told at its end.
#pragma once

#include <cstdint>
#include <string>

#include "firmware/strobe/strobe.hpp"
#include "firmware/transmit/transmitter.hpp"

namespace srd::firmware {

struct RunReport {
  std::uint64_t captured = 0, records = 0, surfaces = 0, acquired = 0, lost_tracks = 0;
  std::uint64_t dropped_by_source = 0, dropped_late = 0, bad = 0, disconnects = 0;
  std::uint64_t dropped_transmit = 0;            // records given up: no room on the way to the host
  std::uint64_t hurried = 0;                     // frames whose fit the deadline ended
  std::uint64_t singular = 0;                    // frames whose corners do not determine the coefficients
  std::string singular_why;                      // of the last one
  std::string camera_faults, camera_last_words;  // of the driver; empty: nothing to say
  // Of the capturing and the processing thread, after their first frames.
  std::uint64_t minor_faults = 0, major_faults = 0;
  bool recording = false;                   // frames were kept on disk
  std::string recorded_to, record_problem;  // the folder; why it ended before the run did or never began, else empty
  std::uint64_t recorded = 0, record_dropped = 0;
  StrobeReport strobe;
  std::string without_surface;  // why, and what to look at, when not one record has a surface; else empty
  bool sent = false;            // whether there was a host to send to
  TransmitterReport transmitter;
  double seconds = 0;
  // For a person, one line a subject.
  [[nodiscard]] std::string text() const;
};

}  // namespace srd::firmware
