// SPDX-License-Identifier: Apache-2.0
// What a scene's camera sees, as an image of its own.
#pragma once

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/recording/image_file.hpp"

namespace srd::fakes {

// The pattern without water where dry, else the first frame.
inline GrayImage picture_of(const srd::Scene& scene, bool dry = true) {
  auto renderer = Renderer::make(scene).value();
  GrayImage image{std::vector<std::uint8_t>(static_cast<std::size_t>(scene.width() * scene.height())), scene.width(),
                  scene.height()};
  const GrayBuffer buffer{image.pixels.data(), image.width, image.height, image.width};
  if (dry) {
    renderer.render_reference(buffer);
  } else {
    renderer.render(0, buffer);
  }
  return image;
}

}  // namespace srd::fakes
