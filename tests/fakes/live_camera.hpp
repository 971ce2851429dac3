// SPDX-License-Identifier: Apache-2.0
// What live cameras made for a test have in common: a size, and buffers that nobody has to give back.
#pragma once

#include "drivers/camera/camera.hpp"

namespace srd::fakes {

class LiveCamera : public Camera {
 public:
  LiveCamera(int width, int height) : width_(width), height_(height) {}
  Outcome<void> start() override { return {}; }
  void give_back(const CameraFrame&) noexcept override {}
  void stop() noexcept override {}
  int width() const override { return width_; }
  int height() const override { return height_; }
  int buffer_count() const override { return 4; }
  bool live() const override { return true; }

 private:
  int width_, height_;
};

}  // namespace srd::fakes
