// SPDX-License-Identifier: Apache-2.0
// srd_prerender FILE [FRAMES]: the scene "frame" as a sequence for frame_instructions.
#include <cstdio>
#include <cstdlib>

#include "tests/bench/prerendered.hpp"

int main(int argc, char** argv) {
  const int frames = argc > 2 ? std::atoi(argv[2]) : 32;
  if (argc < 2 || argc > 3 || frames < 1 || frames > 1000) {
    (void)std::fprintf(stderr, "usage: srd_prerender FILE [FRAMES, 1..1000]\n");
    return 2;
  }
  if (!srd::bench::write_sequence(argv[1], srd::bench::prerendered_frames(frames))) {
    (void)std::fprintf(stderr, "srd_prerender: cannot write %s\n", argv[1]);
    return 3;
  }
  return 0;
}
