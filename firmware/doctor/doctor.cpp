#include "firmware/doctor/doctor.hpp"

namespace srd::firmware {

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
  if (usable) check_camera(settings, options, diagnosis);
  check_gpio({}, options, diagnosis);
  check_clock(settings, options, diagnosis);
  check_permissions(settings, diagnosis);
  if (usable) {
    check_network(settings, options, diagnosis);
    check_disk(settings, options, diagnosis);
  }
  check_board(options, diagnosis);
}

}  // namespace srd::firmware
