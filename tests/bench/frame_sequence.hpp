// SPDX-License-Identifier: Apache-2.0
// Frames rendered beforehand and all that the board's chain must know to read them, in one file. Needs dsp and proto only,
// so that the chain can be built and counted for a board without image libraries.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dsp/pipeline/surface_tracker.hpp"

namespace srd::bench {

struct FrameSequence {
  int width = 0, height = 0;  // px
  double rate_hz = 50;
  dsp::View<double> view;
  dsp::Media<double> media;  // without plates
  dsp::SurfaceModel<double> model;
  int rows = 0, columns = 0;
  double square_mm = 0;
  double level_guess_mm = 0;
  std::vector<std::vector<std::uint8_t>> frames;  // width x height each

  [[nodiscard]] int size() const { return static_cast<int>(frames.size()); }
  [[nodiscard]] GrayView image(int frame) const {
    return {frames[static_cast<std::size_t>(frame)].data(), width, height, width};
  }
  [[nodiscard]] std::int64_t time_ns(int frame) const { return static_cast<std::int64_t>(frame * (1e9 / rate_hz)); }
  [[nodiscard]] std::vector<dsp::Vec3<double>> points() const;
};

// False: the file cannot be written.
[[nodiscard]] bool write_sequence(const std::string& file, const FrameSequence& sequence);
// nullopt: no such file, or not one of ours. Modes must be a published prefix.
[[nodiscard]] std::optional<FrameSequence> read_sequence(const std::string& file);

}  // namespace srd::bench
