// SPDX-License-Identifier: Apache-2.0
#include "host/run/found_index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/support/rank_text.hpp"
#include "drivers/support/text_file.hpp"

namespace srd::host {

namespace {

std::string formatted(const char* format, double value) {
  std::array<char, 64> buffer;
  const int length = std::snprintf(buffer.data(), buffer.size(), format, value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

}  // namespace

std::optional<FoundIndex> found_index(const RunPlan& plan, const RunResult& result) {
  // Below what the index of water means at all; exact features have no deviation to weigh with.
  constexpr double kMinDeviation = 1e-9;
  if (!plan.options.free_index) return std::nullopt;
  FoundIndex found;
  double weights = 0, sum = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.has_surface()) continue;
    const double deviation = std::max(frame.estimate.index_deviation, kMinDeviation);
    weights += 1 / (deviation * deviation);
    sum += frame.estimate.index / (deviation * deviation);
    ++found.frames;
  }
  if (found.frames == 0) return std::nullopt;
  found.mean = sum / weights;
  double squares = 0;
  for (const FrameRecord& frame : result.frames)
    if (frame.has_surface()) squares += std::pow(frame.estimate.index - found.mean, 2);
  const double n = static_cast<double>(found.frames);
  if (found.frames > 1) found.scatter = std::sqrt(squares / (n - 1));
  found.deviation = std::max(1 / std::sqrt(weights), found.scatter / std::sqrt(n));
  return found;
}

double index_of(const RunPlan& plan, const RunResult& result) {
  const auto found = found_index(plan, result);
  return found ? found->mean : plan.media.water;
}

std::string index_text(const RunPlan& plan, const RunResult& result) {
  const auto found = found_index(plan, result);
  if (!found) return number_text(plan.media.water);
  return formatted("%.6f", found->mean) + " +- " + formatted("%.2g", found->deviation) + " (estimated in " +
         std::to_string(found->frames) + " frames, which scatter by " + formatted("%.2g", found->scatter) + ")";
}

std::vector<std::string> rank_warnings(const RunPlan& plan, const RunResult& result) {
  std::vector<std::pair<std::string, std::size_t>> reasons;
  for (const FrameRecord& frame : result.frames) {
    std::string reason;
    if (frame.estimate.stop == dsp::Stop::kIndexUndetermined)
      reason = "no surface, since the index of water cannot be estimated (its standard deviation would be " +
               formatted("%.2g", frame.estimate.index_deviation) + "): ";
    else if (frame.estimate.stop == dsp::Stop::kSingular)
      reason = "no surface: ";
    const std::string text = rank_text(frame.estimate.rank, plan.model.modes);
    if (text.empty()) continue;
    // Deviations differ from frame to frame: the first one's stands for all.
    const auto same =
        std::find_if(reasons.begin(), reasons.end(), [&](const auto& known) { return known.first.ends_with(text); });
    if (same == reasons.end())
      reasons.emplace_back(reason + text, 1);
    else
      ++same->second;
  }
  std::vector<std::string> warnings;
  for (const auto& [reason, count] : reasons)
    warnings.push_back(std::to_string(count) + " of " + std::to_string(result.frames.size()) + " frames: " + reason);
  return warnings;
}

}  // namespace srd::host
