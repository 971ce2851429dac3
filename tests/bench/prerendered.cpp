// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/prerendered.hpp"

#include "drivers/camera/simulator/renderer.hpp"
#include "tests/bench/scenes.hpp"

namespace srd::bench {

FrameSequence prerendered_frames(int frames) {
  const Scene scene = frame_scene();
  Renderer renderer = Renderer::make(scene).value();
  FrameSequence s;
  s.width = scene.width();
  s.height = scene.height();
  s.rate_hz = scene.rate_hz;
  s.view = scene.view();
  s.media = scene.media;
  s.model = scene.surface;
  s.rows = scene.pattern.rows;
  s.columns = scene.pattern.columns;
  s.square_mm = scene.pattern.square_mm;
  s.level_guess_mm = 80;
  for (int i = 0; i < frames; ++i) {
    auto& frame = s.frames.emplace_back(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height));
    renderer.render(static_cast<std::uint64_t>(i), {frame.data(), s.width, s.height, s.width});
  }
  return s;
}

}  // namespace srd::bench
