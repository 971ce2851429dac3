// SPDX-License-Identifier: Apache-2.0
// The scene "frame", rendered.
#pragma once

#include "tests/bench/frame_sequence.hpp"

namespace srd::bench {

[[nodiscard]] FrameSequence prerendered_frames(int frames);

}  // namespace srd::bench
