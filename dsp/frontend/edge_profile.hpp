// The step edge seen through a Gaussian blur: E(s) = erf(s / sqrt 2) and D(s) = E'(s) = sqrt(2/pi) exp(-s^2/2), in tables.
#pragma once

#include <array>
#include <cstdint>

namespace srd::dsp {

// s in Q8 standard deviations, |s| clamped to 4; values in Q14 (E: +-16384, D: <= 13073). Nearest entry: the step of
// E between entries is at most 51 (0.3 %), well below the noise of one pixel, and symmetric about the edge.
class EdgeProfile {
 public:
  static constexpr int kQ = 14;
  static constexpr int kArgumentQ = 8;
  static constexpr int kReach = 4 << kArgumentQ;

  struct Value {
    std::int32_t step;   // E
    std::int32_t slope;  // D
  };
  [[nodiscard]] static Value at(std::int64_t s_q8) {
    const bool negative = s_q8 < 0;
    const std::int64_t size = negative ? -s_q8 : s_q8;
    const std::size_t i = static_cast<std::size_t>(size > kReach ? kReach : size);
    const std::int32_t e = table().step[i];
    return {negative ? -e : e, table().slope[i]};
  }

 private:
  struct Table {
    std::array<std::int16_t, kReach + 1> step;
    std::array<std::int16_t, kReach + 1> slope;
  };
  // Made by the compiler, so that no machine's libm has a say in it.
  static constexpr Table make() {
    Table t{};
    for (int i = 0; i <= kReach; ++i) {
      const double s = static_cast<double>(i) / (1 << kArgumentQ);
      // erf(s/sqrt2) = sqrt(2/pi) exp(-s^2/2) (s + s^3/3 + s^5/15 + ..): all terms positive, no cancellation.
      double term = s, sum = s;
      for (int k = 1; k < 120; ++k) {
        term *= s * s / (2 * k + 1);
        sum += term;
      }
      double e = 1, p = 1;  // exp(-s^2/2) as 1 / exp(s^2/2)
      for (int k = 1; k < 80; ++k) {
        p *= s * s / 2 / k;
        e += p;
      }
      const double d = 0.7978845608028654 / e;
      t.step[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(sum * d * (1 << kQ) + 0.5);
      t.slope[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(d * (1 << kQ) + 0.5);
    }
    return t;
  }
  static const Table& table();
};

}  // namespace srd::dsp
