// SPDX-License-Identifier: Apache-2.0
// File names in the order that a person means: frame_2 before frame_10, -6 before 5, t_0.25 before t_0.5 before t_1.
#pragma once

#include <string>
#include <vector>

namespace srd {

// Sorts names: runs of digits compare as numbers, all else byte by byte. What a '-' or a '.' beside digits is, all names
// together say:
//   a sign: a '-' or '+' before digits that opens the name or follows a separator ("-6", "t_-6"), or follows letters where
//     another name has none or the other one there ("z-6" beside "z5"); after a digit it never is one ("2017-03-04"), nor
//     where all names have it after a letter ("img-5");
//   a fraction: one '.' between digits ("0.25"), unless the digits behind look counted ("1.9", "1.10"); two of them never
//     are ("2017.03.04").
// Returns a line for a person where another reading of these marks would give another order, else nothing.
[[nodiscard]] std::string sort_naturally(std::vector<std::string>& names);

}  // namespace srd
