// SPDX-License-Identifier: Apache-2.0
// Where the next fit may start: the last surfaces, their trend, the configured guess. Optics (16).
// The estimator takes the one that costs least on the new corners. One thread per object; no heap.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>

#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
class StartHistory {
 public:
  static constexpr int kKept = 4;         // surfaces
  static constexpr int kMax = kKept + 2;  // starts
  // A trend is drawn out to at most this many times the two frames' own distance in time: beyond, it leads away.
  static constexpr std::int64_t kFarthest = 4;

  enum class Kind : std::uint8_t { kPrevious, kTrend, kGuess };

  explicit StartHistory(const Coefficients<S>& guess) : guess_(guess) {}

  // A frame's surface. Frames without one are simply not added: times tell how many are missing. One that is not
  // finite, or has another number of coefficients than the guess, is not taken. A time before the newest means another
  // clock or a recording begun again: what was known is forgotten. The newest time again replaces the newest.
  void add(std::int64_t time_ns, const Coefficients<S>& surface) {
    if (surface.size() != guess_.size() || !surface.allFinite()) return;
    if (size_ > 0 && time_ns < at(0).time_ns) size_ = 0;
    if (size_ == 0 || time_ns > at(0).time_ns) {
      newest_ = (newest_ + 1) % kKept;
      if (size_ < kKept) ++size_;
    }
    surfaces_[static_cast<std::size_t>(newest_)] = {time_ns, surface};
  }

  // After a change of model, pose or source.
  void reset() { size_ = 0; }
  void reset(const Coefficients<S>& guess) {
    guess_ = guess;
    size_ = 0;
  }

  // For a frame at time_ns: previous surfaces, newest first; their trend, where two are known and the time lies at most
  // kFarthest of their distance after the newest; the guess. At least one; valid until the next call.
  [[nodiscard]] std::span<const Coefficients<S>> starts(std::int64_t time_ns) {
    n_starts_ = 0;
    for (int i = 0; i < size_; ++i) push(at(i).surface, Kind::kPrevious);
    if (has_trend(time_ns)) push(trend(time_ns), Kind::kTrend);
    push(guess_, Kind::kGuess);
    return std::span(starts_).first(static_cast<std::size_t>(n_starts_));
  }
  // Of the last call's start i.
  [[nodiscard]] Kind kind(int i) const {
    assert(i >= 0 && i < n_starts_);
    return kinds_[static_cast<std::size_t>(i)];
  }

  // The surface to expect at time_ns, before its corners are known: the trend, else the newest, else the guess.
  [[nodiscard]] Coefficients<S> expected(std::int64_t time_ns) const {
    if (has_trend(time_ns)) return trend(time_ns);
    return size_ > 0 ? at(0).surface : guess_;
  }

  [[nodiscard]] int size() const { return size_; }

 private:
  struct Known {
    std::int64_t time_ns = 0;
    Coefficients<S> surface;
  };

  // i-th newest.
  [[nodiscard]] const Known& at(int i) const { return surfaces_[static_cast<std::size_t>((newest_ + kKept - i) % kKept)]; }
  [[nodiscard]] bool has_trend(std::int64_t time_ns) const {
    if (size_ < 2 || time_ns <= at(0).time_ns) return false;
    return (time_ns - at(0).time_ns) / kFarthest <= at(0).time_ns - at(1).time_ns;
  }
  [[nodiscard]] Coefficients<S> trend(std::int64_t time_ns) const {
    const S ratio =
        static_cast<S>(static_cast<double>(time_ns - at(0).time_ns) / static_cast<double>(at(0).time_ns - at(1).time_ns));
    return at(0).surface + ratio * (at(0).surface - at(1).surface);
  }
  void push(const Coefficients<S>& surface, Kind kind) {
    starts_[static_cast<std::size_t>(n_starts_)] = surface;
    kinds_[static_cast<std::size_t>(n_starts_++)] = kind;
  }

  Coefficients<S> guess_;
  std::array<Known, kKept> surfaces_{};
  int size_ = 0, newest_ = 0;
  std::array<Coefficients<S>, kMax> starts_{};
  std::array<Kind, kMax> kinds_{};
  int n_starts_ = 0;
};

}  // namespace srd::dsp
