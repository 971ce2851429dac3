// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/doctor.hpp"

#include <functional>
#include <vector>

namespace srd::firmware {

namespace {

// That a measurement with this configuration drives: only live cameras are strobed.
std::vector<LineAddress> strobe_lines(const NodeConfig& config) {
  const StrobeSection& strobe = config.strobe;
  std::vector<LineAddress> lines;
  if (strobe.mode == StrobeMode::kOff || !config.camera || !config.camera->live()) return lines;
  if (!strobe.line.empty()) lines.push_back(strobe.line_address());
  if (strobe.mode == StrobeMode::kTrigger) lines.push_back(strobe.trigger_address());
  return lines;
}

}  // namespace

void examine(const Outcome<NodeConfig>* config, const DoctorOptions& options, Diagnosis& diagnosis) {
  NodeConfig defaults;
  const bool usable = config != nullptr && config->ok();
  if (config == nullptr) {
    diagnosis.warn("configuration", "none: camera, host and disk are passed over", "--config FILE; board/ has profiles");
  } else if (!usable) {
    diagnosis.fail("configuration", config->error());
  } else {
    diagnosis.ok("configuration", (*config)->file.string());
  }
  const NodeConfig& settings = usable ? **config : defaults;
  const std::function<void()> parts[] = {
      [&] {
        if (usable) check_camera(settings, options, diagnosis);
      },
      [&] { check_gpio(strobe_lines(settings), options, diagnosis); },
      [&] { check_clock(settings, options, diagnosis); },
      [&] { check_permissions(settings, diagnosis); },
      [&] {
        if (usable) check_network(settings, options, diagnosis);
      },
      [&] {
        if (usable) check_disk(settings, options, diagnosis);
      },
      [&] { check_board(options, diagnosis); },
  };
  for (const auto& part : parts)
    if (!options.stopping()) part();
}

}  // namespace srd::firmware
