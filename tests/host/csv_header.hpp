// SPDX-License-Identifier: Apache-2.0
// The first line of a file of coefficients with three modes, as tests write it.
#pragma once

#include <string>

namespace srd::host {

inline const std::string kThreeModesHeader =
    "node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,"
    "A00,B,C,sd_A00,sd_B,sd_C\n";

}  // namespace srd::host
