// SPDX-License-Identifier: Apache-2.0
// Which of the boards that see one surface has moved: each against what the others say (disagreement.hpp).
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host/fusion/disagreement.hpp"
#include "host/fusion/information_sum.hpp"

namespace srd::host {

// A board's word at one moment.
struct Part {
  std::string name;
  std::uint32_t bit = 0;  // of the set of boards: another for each
  TimedSurface surface;
  const BoardMap* map = nullptr;
  Contribution contribution;
};

class BoardWatch {
 public:
  // In deviations of a normal variable: were the means normal, 32 boards would show this once in a million years.
  static constexpr double kTold = 8;

  // A moment, before it is fused. The parts of boards that have moved are to be left out then. False: the boards contradict
  // each other at this moment, and nobody can say which is wrong.
  bool look(std::int64_t time_ns, std::span<const Part> parts, Eigen::Index modes);
  // The board has a new pose: what was learned of it counts no more.
  void forget(const std::string& name);

  [[nodiscard]] bool has_moved(const std::string& name) const;
  struct Event {
    std::string name;
    bool moved = true;        // false: it agrees with the others again
    bool one_of_two = false;  // it or the other of two boards: nobody can say which
    double significance = 0;
    Eigen::VectorXd shift_mm;  // of its coefficients
  };
  // Since the last call.
  [[nodiscard]] std::vector<Event> take_events();

 private:
  struct State {
    std::map<std::uint32_t, Disagreement> by_set;
    bool moved = false, told = false;
  };
  std::map<std::string, State> boards_;
  std::vector<Event> events_;
};

}  // namespace srd::host
