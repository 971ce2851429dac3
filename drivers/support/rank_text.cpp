// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/rank_text.hpp"

#include "drivers/support/mode_names.hpp"

namespace srd {

namespace {

std::string name_of(int parameter, const dsp::ModeList& modes) {
  return parameter < modes.size() ? mode_name(modes[parameter]) : "the index of water";
}

}  // namespace

std::string rank_text(const dsp::RankReport& report, const dsp::ModeList& modes) {
  std::string text;
  for (int i = 0; i < report.n_dependences; ++i) {
    const dsp::Dependence& dependence = report.dependences[static_cast<std::size_t>(i)];
    const std::string name = name_of(dependence.parameter, modes);
    if (!text.empty()) text += "; ";
    if (dependence.n_others == 0) {
      text += name + " has no effect on the corners";
      continue;
    }
    text += dependence.pivot > dsp::kRankThreshold ? "the view can hardly separate " : "the view cannot separate ";
    text += name + " from ";
    for (int j = 0; j < dependence.n_others; ++j) {
      if (j > 0) text += j + 1 == dependence.n_others ? " and " : ", ";
      text += name_of(dependence.others[static_cast<std::size_t>(j)], modes);
    }
  }
  return text;
}

}  // namespace srd
