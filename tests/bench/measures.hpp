// SPDX-License-Identifier: Apache-2.0
// Everything that srd_bench times: ours and the baselines, on the same images and residuals, in one process.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace srd::bench {

struct Measure {
  std::string name;
  std::function<void()> run;  // once
  bool slow = false;          // a tenth of a second and more
};

// A bar: baseline over ours must be at least factor.
struct Bar {
  std::string what;
  std::string ours, baseline;  // names of measures
  double factor;
};

// Renders the scenes, warms everything up, and checks that ours and the baselines do the same work; says on stderr and
// ends the program when they do not. Call once.
[[nodiscard]] std::vector<Measure> make_measures();
[[nodiscard]] const std::vector<Bar>& bars();

// Each measure runs rounds times, turn by turn, so that what else the machine does hits all alike. Prints medians of
// thread CPU time and the bars. 0.
int print_table(const std::vector<Measure>& measures, int rounds);

// Parts of make_measures.
void add_board_measures(std::vector<Measure>& measures);
void add_frame_measures(std::vector<Measure>& measures);
void add_solve_measures(std::vector<Measure>& measures);
[[noreturn]] void refuse(const std::string& why);

}  // namespace srd::bench
