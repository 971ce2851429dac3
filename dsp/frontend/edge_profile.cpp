#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {

namespace {

// Made by the compiler, so that no machine's libm has a say in it.
constexpr EdgeProfile::Table make() {
  EdgeProfile::Table table{};
  for (int i = 0; i < EdgeProfile::kCells; ++i) {
    // The cell holds four numbers of Q10: their mean.
    const double middle = (4 * i + 1.5 - EdgeProfile::kReachQ10) / 1024;
    const double s = middle < 0 ? -middle : middle;
    // erf(s/sqrt2) = sqrt(2/pi) exp(-s^2/2) (s + s^3/3 + s^5/15 + ..): all terms positive, no cancellation.
    double term = s, sum = s;
    for (int k = 1; term > 1e-9; ++k) {
      term *= s * s / (2 * k + 1);
      sum += term;
    }
    double power = 1, e = 1;  // exp(-s^2/2) as 1 / exp(s^2/2)
    for (int k = 1; power > 1e-9; ++k) {
      power *= s * s / 2 / k;
      e += power;
    }
    const double d = 0.7978845608028654 / e;
    const int step = static_cast<int>(sum * d * (1 << 14) + 0.5);
    table[static_cast<std::size_t>(i)] = {static_cast<std::int16_t>(middle < 0 ? -step : step),
                                          static_cast<std::int16_t>(d * (1 << 14) + 0.5)};
  }
  return table;
}

}  // namespace

const EdgeProfile::Table& EdgeProfile::table() {
  alignas(64) static constexpr Table kTable = make();
  return kTable;
}

}  // namespace srd::dsp
