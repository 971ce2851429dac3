// SPDX-License-Identifier: Apache-2.0
// The largest sizes that files may name: beyond, a number is a slip of the pen or a damaged file.
#pragma once

namespace srd {

inline constexpr int kMaxSide = 65535;  // of an image, px
inline constexpr double kMaxMm = 1e6;   // of a length or a place

}  // namespace srd
