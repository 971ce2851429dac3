#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {

const EdgeProfile::Table& EdgeProfile::table() {
  static constexpr Table kTable = make();
  return kTable;
}

}  // namespace srd::dsp
