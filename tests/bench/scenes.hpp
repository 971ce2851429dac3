// SPDX-License-Identifier: Apache-2.0
// The scenes that speed and accuracy are stated for.
#pragma once

#include "drivers/camera/simulator/scene.hpp"

namespace srd::bench {

// 1920x1080, 880 corners, squares of about 38 px, turned and in perspective, blur 0.9, noise 2, contrast 200. Dry: a
// thin level sheet of index 1 lies on it, so every frame shows the same board. variant moves and turns it a little.
[[nodiscard]] Scene board_scene(int variant = 0);

// 1280x640, 11 x 21 corners of 20 mm under 80 mm of water with five modes of 3 mm; blur 0.7, noise 1.5; 50 Hz.
[[nodiscard]] Scene flume_scene();
// The same with eight modes, blur 1.2, noise 4, a lighting gradient of 40 % and glare on about 3 % of the corners.
[[nodiscard]] Scene hard_flume_scene();
// The same as flume_scene, with waves that move corners by up to 8 px from one frame to the next.
[[nodiscard]] Scene fast_flume_scene();

// 1920x1080, 12 x 23 = 276 corners, twelve modes.
[[nodiscard]] Scene frame_scene();

}  // namespace srd::bench
