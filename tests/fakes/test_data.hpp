// SPDX-License-Identifier: Apache-2.0
// Where tests/data is. A function, so that one source alone is compiled again in another folder.
#pragma once

#include <filesystem>

namespace srd::fakes {

[[nodiscard]] std::filesystem::path test_data();

}  // namespace srd::fakes
