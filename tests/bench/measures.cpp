// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/measures.hpp"

#include <cstdio>
#include <cstdlib>

namespace srd::bench {

void refuse(const std::string& why) {
  (void)std::fprintf(stderr, "srd_bench: %s\n", why.c_str());
  std::exit(1);
}

std::vector<Measure> make_measures() {
  std::vector<Measure> measures;
  add_board_measures(measures);
  add_frame_measures(measures);
  add_solve_measures(measures);
  return measures;
}

const std::vector<Bar>& bars() {
  static const std::vector<Bar> bars{
      {"full detection of Board (880 corners)", "board/detect", "board/cornerHarris", 10},
      {"Frame, camera buffer -> datagram", "frame/chain", "frame/cornerHarris", 40},
      {"tag of a datagram, against the whole frame", "frame/tag", "frame/chain", 50},
      {"solve 276 points, 12 parameters, warm (double)", "solve/ours_double", "solve/ceres", 10},
      {"the same in float, as on the board", "solve/ours_float", "solve/ceres", 10},
  };
  return bars;
}

}  // namespace srd::bench
