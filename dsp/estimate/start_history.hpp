// Where the next frame's fit starts: the four previous surfaces, their linear extrapolation, the configured guess.
// Optics (16). No heap; times only by their differences, ns.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
class StartHistory {
 public:
  StartHistory() = default;
  explicit StartHistory(const Coefficients<S>& guess) : guess_(guess), predicted_(guess) {}

  // A surface of this frame. A time that does not advance starts the trend anew.
  void add(std::int64_t time_ns, const Coefficients<S>& a) {
    for (std::size_t i = kDepth - 1; i > 0; --i) previous_[i] = previous_[i - 1];
    previous_[0] = {time_ns, a};
    count_ = std::min(count_ + 1, kDepth);
    missed_ = 0;
    if (count_ > 1 && previous_[1].time_ns >= time_ns) count_ = 1;
  }
  // A frame without a surface. After kPatience of them in a row the past says nothing any more.
  void miss() {
    if (++missed_ > kPatience) count_ = 0;
  }
  void reset() { count_ = 0; }

  [[nodiscard]] bool any() const { return count_ > 0; }
  // The newest surface, or the guess.
  [[nodiscard]] const Coefficients<S>& last() const { return count_ > 0 ? previous_[0].a : guess_; }

  // The surface expected at a time: the last one moved on by its trend, at most kFarthest frame intervals.
  [[nodiscard]] const Coefficients<S>& predicted(std::int64_t time_ns) {
    if (count_ < 2) return predicted_ = last();
    const S interval = static_cast<S>(previous_[0].time_ns - previous_[1].time_ns);
    const S ahead = static_cast<S>(time_ns - previous_[0].time_ns) / interval;
    // Backwards, or so far ahead that a trend is worth nothing.
    if (!(ahead > 0) || ahead > kFarthest) return predicted_ = last();
    return predicted_ = previous_[0].a + ahead * (previous_[0].a - previous_[1].a);
  }

  // All starts, the likeliest first: one to six.
  [[nodiscard]] std::span<const Coefficients<S>> starts(std::int64_t time_ns) {
    std::size_t n = 0;
    starts_[n++] = predicted(time_ns);
    for (std::size_t i = 0; i < count_; ++i) starts_[n++] = previous_[i].a;
    starts_[n++] = guess_;
    return std::span(starts_).first(n);
  }

 private:
  static constexpr std::size_t kDepth = 4;
  static constexpr int kPatience = 25;
  static constexpr S kFarthest = 3;

  struct Past {
    std::int64_t time_ns = 0;
    Coefficients<S> a;
  };
  Coefficients<S> guess_, predicted_;
  std::array<Past, kDepth> previous_{};
  std::size_t count_ = 0;
  int missed_ = 0;
  std::array<Coefficients<S>, kDepth + 2> starts_{};
};

}  // namespace srd::dsp
