// SPDX-License-Identifier: Apache-2.0
// frame_instructions FILE N: the chain over the first N frames of a prerendered sequence, and nothing besides. Run with N
// and 2N under an instruction counter; the difference over N is one tracked frame.
#include <cstdio>
#include <cstdlib>

#include "tests/bench/frame_chain.hpp"

int main(int argc, char** argv) {
  if (argc != 3) {
    (void)std::fprintf(stderr, "usage: frame_instructions FILE FRAMES\n");
    return 2;
  }
  const auto sequence = srd::bench::read_sequence(argv[1]);
  const int frames = std::atoi(argv[2]);
  if (!sequence || frames < 1 || frames > sequence->size()) {
    (void)std::fprintf(stderr, "frame_instructions: %s: no sequence of %d frames; make it with srd_prerender\n", argv[1],
                       frames);
    return 3;
  }
  auto chain = srd::bench::FrameChain::make(*sequence);
  if (!chain) return 3;
  int surfaces = 0, acquired = 0;
  long corners = 0, bytes = 0;
  for (int frame = 0; frame < frames; ++frame) {
    bytes += static_cast<long>(chain->process(sequence->image(frame), sequence->time_ns(frame)));
    surfaces += chain->result().has_surface() ? 1 : 0;
    acquired += chain->result().acquired ? 1 : 0;
    corners += chain->result().estimate.corners_used;
  }
  std::printf("frames %d surfaces %d acquired %d corners %ld bytes %ld\n", frames, surfaces, acquired, corners, bytes);
  return surfaces == frames && acquired == 1 ? 0 : 1;
}
