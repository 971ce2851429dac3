// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/board_track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "proto/information.hpp"

namespace srd::host {
namespace {

double seconds_between(std::int64_t from, std::int64_t to) { return static_cast<double>(to - from) * 1e-9; }

}  // namespace

std::optional<TimedSurface> timed_surface(std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  if (frame.status != proto::FrameStatus::kOk || !frame.has_surface() || frame.at_bound || frame.information.size == 0)
    return std::nullopt;
  TimedSurface out;
  out.time_ns = frame.stamp.wall_time_ns;
  out.clock_sd_s = static_cast<double>(frame.stamp.wall_uncertainty_ns) * 1e-9;
  out.sequence = sequence;
  out.coefficients = frame.coefficients.cast<double>();
  const Eigen::MatrixXd factor = proto::expand(frame.information);
  const Eigen::MatrixXd inverse =
      factor.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(factor.rows(), factor.cols()));
  out.covariance = inverse * inverse.transpose();
  if (!out.covariance.allFinite() || !out.coefficients.allFinite()) return std::nullopt;
  out.corners_expected = frame.corners_expected;
  out.corners_found = frame.corners_found;
  out.corners_used = frame.corners_used;
  out.reprojection_rms_px = static_cast<double>(frame.reprojection_rms_px);
  return out;
}

bool BoardTrack::add(TimedSurface surface) {
  if (!frames_.empty() && surface.time_ns <= frames_.back().time_ns) return false;
  frames_.push_back(std::move(surface));
  if (frames_.size() > kMost) frames_.pop_front();
  return true;
}

std::uint64_t BoardTrack::forget_before(std::int64_t time_ns) {
  std::uint64_t unused = 0;
  while (frames_.size() > 2 && frames_[2].time_ns < time_ns) {
    unused += frames_.front().used ? 0 : 1;
    frames_.pop_front();
  }
  return unused;
}

void BoardTrack::mark_used(std::int64_t time_ns) {
  if (!frames_.empty()) frames_[nearest(time_ns)].used = true;
}

std::uint64_t BoardTrack::unused() const {
  return static_cast<std::uint64_t>(
      std::count_if(frames_.begin(), frames_.end(), [](const TimedSurface& frame) { return !frame.used; }));
}

double BoardTrack::usual_step_s() const {
  if (frames_.size() < 2) return 0;
  return seconds_between(frames_.front().time_ns, frames_.back().time_ns) / static_cast<double>(frames_.size() - 1);
}

std::size_t BoardTrack::nearest(std::int64_t time_ns) const {
  const auto next = std::lower_bound(frames_.begin(), frames_.end(), time_ns,
                                     [](const TimedSurface& frame, std::int64_t time) { return frame.time_ns < time; });
  const auto after = static_cast<std::size_t>(next - frames_.begin());
  if (after == 0) return 0;
  if (after == frames_.size()) return after - 1;
  return frames_[after].time_ns - time_ns < time_ns - frames_[after - 1].time_ns ? after : after - 1;
}

std::optional<TimedSurface> BoardTrack::at(std::int64_t time_ns, double pair_s, double step_s) const {
  if (frames_.empty()) return std::nullopt;
  const std::size_t index = nearest(time_ns);
  const TimedSurface* middle = &frames_[index];
  const double t = seconds_between(middle->time_ns, time_ns);
  if (middle->used || std::abs(t) > pair_s) return std::nullopt;
  const TimedSurface* before = index > 0 ? &frames_[index - 1] : nullptr;
  const TimedSurface* after = index + 1 < frames_.size() ? &frames_[index + 1] : nullptr;
  if (before != nullptr && seconds_between(before->time_ns, middle->time_ns) > step_s) before = nullptr;
  if (after != nullptr && seconds_between(middle->time_ns, after->time_ns) > step_s) after = nullptr;

  // Without a neighbour nothing says how fast the surface moves, and so not what the time's error means.
  if (before == nullptr && after == nullptr) return std::nullopt;

  TimedSurface out = *middle;
  out.time_ns = time_ns;
  Eigen::VectorXd speed = Eigen::VectorXd::Zero(out.coefficients.size());  // mm/s
  if (before != nullptr && after != nullptr) {
    // Lagrange's weights at t for the times a < 0 < b.
    const double a = seconds_between(middle->time_ns, before->time_ns), b = seconds_between(middle->time_ns, after->time_ns);
    const double wa = t * (t - b) / (a * (a - b)), wb = t * (t - a) / (b * (b - a)), w0 = (t - a) * (t - b) / (a * b);
    out.coefficients = wa * before->coefficients + w0 * middle->coefficients + wb * after->coefficients;
    out.covariance = wa * wa * before->covariance + w0 * w0 * middle->covariance + wb * wb * after->covariance;
    speed = (2 * t - b) / (a * (a - b)) * before->coefficients + (2 * t - a - b) / (a * b) * middle->coefficients +
            (2 * t - a) / (b * (b - a)) * after->coefficients;
  } else {
    const TimedSurface& other = before != nullptr ? *before : *after;
    const double h = seconds_between(middle->time_ns, other.time_ns);
    speed = (other.coefficients - middle->coefficients) / h;
    // Between the two; beyond them a line says little of what a wave does.
    const double w = t / h;
    if (w >= 0) {
      out.coefficients += w * (other.coefficients - middle->coefficients);
      out.covariance = (1 - w) * (1 - w) * middle->covariance + w * w * other.covariance;
    } else {
      out.covariance += t * t * speed * speed.transpose();
    }
  }
  out.covariance += out.clock_sd_s * out.clock_sd_s * speed * speed.transpose();
  return out;
}

}  // namespace srd::host
