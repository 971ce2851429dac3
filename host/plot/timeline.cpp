// SPDX-License-Identifier: Apache-2.0
#include "host/plot/timeline.hpp"

#include <algorithm>
#include <cmath>

namespace srd::host {
namespace {

constexpr double kLongestInterval = 1.5;  // of the median: a frame left out makes it 2

bool next_in_sequence(const CoefficientRow& before, const CoefficientRow& row) {
  return row.boot == before.boot && missing_between(before, row) == 0 && row.time_ns > before.time_ns;
}

double interval(const CoefficientRow& before, const CoefficientRow& row) {
  return static_cast<double>(row.time_ns - before.time_ns) * 1e-9;
}

}  // namespace

Timeline make_timeline(const CoefficientRun& run) {
  Timeline timeline;
  std::vector<double> intervals;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    timeline.seconds.push_back(interval(run.rows[0], run.rows[i]));
    if (i > 0 && next_in_sequence(run.rows[i - 1], run.rows[i])) intervals.push_back(interval(run.rows[i - 1], run.rows[i]));
  }
  if (!intervals.empty()) {
    const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
    std::nth_element(intervals.begin(), middle, intervals.end());
    timeline.interval_s = *middle;
  }
  timeline.follows.assign(run.rows.size(), false);
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    timeline.follows[i] = next_in_sequence(run.rows[i - 1], run.rows[i]) &&
                          interval(run.rows[i - 1], run.rows[i]) <= kLongestInterval * timeline.interval_s;
  return timeline;
}

Stretches unbroken(const Timeline& timeline, std::span<const double> values) {
  Stretches out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (!out.empty() && out.back().second == i && timeline.follows[i])
      out.back().second = i + 1;
    else
      out.emplace_back(i, i + 1);
  }
  return out;
}

}  // namespace srd::host
