// SPDX-License-Identifier: Apache-2.0
// The last frames of one board, and its surface at any moment between them.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include <Eigen/Core>

#include "proto/messages.hpp"

namespace srd::host {

// A frame's surface with the covariance of its random error.
struct TimedSurface {
  std::int64_t time_ns = 0;  // wall clock, middle of the light
  double clock_sd_s = 0;     // of it
  std::uint64_t sequence = 0;
  Eigen::VectorXd coefficients;  // mm
  Eigen::MatrixXd covariance;    // mm^2
  std::uint32_t corners_expected = 0, corners_found = 0, corners_used = 0;
  double reprojection_rms_px = 0;
  bool used = false;  // as the nearest to a moment
};

// nullopt: no surface, a surface that is not to be fused (status, a coefficient at its bound), or no information.
[[nodiscard]] std::optional<TimedSurface> timed_surface(std::uint64_t sequence, const proto::CoefficientFrame& frame);

// Bounded: kMost frames. One thread.
class BoardTrack {
 public:
  static constexpr std::size_t kMost = 512;

  // Times must grow within a boot; one that does not is left out (false). Without room the oldest goes.
  bool add(TimedSurface surface);
  void clear() { frames_.clear(); }
  // Frames before are no longer needed, but the two that lead up to them. How many of those that go were not used.
  std::uint64_t forget_before(std::int64_t time_ns);
  // The frame nearest to a moment serves it.
  void mark_used(std::int64_t time_ns);
  [[nodiscard]] std::uint64_t unused() const;
  // s between frames, on average; 0: fewer than two.
  [[nodiscard]] double usual_step_s() const;

  [[nodiscard]] const std::deque<TimedSurface>& frames() const { return frames_; }
  // The surface at a moment: by the parabola through the nearest frame and its two neighbours, by the line through two, or
  // the nearest as it is, its covariance grown by what the surface moved in between. The clock's deviation enters by the
  // surface's speed. nullopt: no frame within pair_s, it stands alone, or it has served. Neighbours further away than step_s are none.
  [[nodiscard]] std::optional<TimedSurface> at(std::int64_t time_ns, double pair_s, double step_s) const;

 private:
  [[nodiscard]] std::size_t nearest(std::int64_t time_ns) const;  // there is a frame

  std::deque<TimedSurface> frames_;
};

}  // namespace srd::host
