// SPDX-License-Identifier: Apache-2.0
// Settings of the 2017 release turned into a run of the pattern metric on their region.
#pragma once

#include "host/opensrd/reconstruction.hpp"

namespace srd::host::opensrd {

// Points of a reference pattern in the order in which the image shows them, row by row, the top left first: the release
// lists them column by column from the image's left, each from the bottom.
[[nodiscard]] Points rows_from_columns(const Points& listed, PatternSize board);

// settings.dialect is k2017. The surface: of the settings (a guess of two numbers is the release's form), unless
// overrides.model says another. Reads the first frame, for the middle of what it shows.
// kUsage: several cameras, overrides for corners. kInput: a file that cannot be used.
[[nodiscard]] Outcome<Preparation> prepare_patch(const Settings& settings, const Overrides& overrides);

}  // namespace srd::host::opensrd
