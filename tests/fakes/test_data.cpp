// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/test_data.hpp"

namespace srd::fakes {

std::filesystem::path test_data() { return SRD_TEST_DATA; }

}  // namespace srd::fakes
