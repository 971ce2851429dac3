// SPDX-License-Identifier: Apache-2.0
#include "firmware/node/report.hpp"

#include <sstream>

namespace srd::firmware {

std::string RunReport::text() const {
  std::ostringstream out;
  out.precision(4);
  out << "frames    " << captured << " captured, " << records << " records, " << surfaces << " with a surface, in " << seconds
      << " s\n"
      << "tracking  found " << acquired << " times, lost " << lost_tracks << " times\n"
      << "dropped   " << dropped_by_source << " by the source, " << dropped_late << " late, " << bad << " unusable\n";
  if (!without_surface.empty()) out << "surface   none in any frame: " << without_surface << "\n";
  if (!camera_faults.empty()) out << "camera    " << camera_faults << "\n";
  out << camera_last_words;
  if (minor_faults + major_faults > 0)
    out << "memory    " << minor_faults << " page faults without the disk, " << major_faults
        << " with it, in the frame loop after its first frames\n";
  out << strobe.text();
  if (hurried > 0) out << "deadline  ended the fit of " << hurried << " frames\n";
  if (singular > 0) out << "singular  " << singular << " frames: " << singular_why << "\n";
  if (recording)
    out << "recorded  " << recorded << " frames to " << recorded_to << ", " << record_dropped << " dropped"
        << (record_problem.empty() ? "" : "; stopped: " + record_problem) << "\n";
  if (!transmitter.host_address.empty()) out << "host      " << transmitter.host_address << "\n";
  if (!transmitter.host_problem.empty()) out << "host      " << transmitter.host_problem << "\n";
  if (sent)
    out << "sent      " << transmitter.counts.datagrams << " datagrams, " << transmitter.counts.resent << " again, "
        << transmitter.counts.lost << " frames lost, " << transmitter.unacknowledged << " not acknowledged\n";
  if (transmitter.spill.written + transmitter.spilled > 0)
    out << "spill     " << transmitter.spilled << " frames stay on the disk for the next start; "
        << transmitter.spill.written_bytes << " bytes written, " << transmitter.spill.syncs << " syncs\n";
  return out.str();
}

}  // namespace srd::firmware
