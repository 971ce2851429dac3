// SPDX-License-Identifier: Apache-2.0
// The figures of `srd study`.
#pragma once

#include <vector>

#include "host/plot/figures.hpp"
#include "host/study/corner_study.hpp"
#include "host/study/surface_study.hpp"

namespace srd::study {

[[nodiscard]] host::Figure corner_figure(const std::vector<CornerRow>& rows);
[[nodiscard]] host::Figure surface_figure(const std::vector<SurfaceRow>& rows);

}  // namespace srd::study
