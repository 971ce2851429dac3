// SPDX-License-Identifier: Apache-2.0
// Where between the pixels the response is largest: a start for the corner fit.
#pragma once

#include "dsp/frontend/chess_response.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

// The top of the paraboloid through the 5x5 responses round (row, column), by least squares: a few hundredths of a pixel
// from the corner, so that one step of the fit is most often enough. Sets u and v only.
// False, and shape as it was: nearer than 2 px to the window's border, or no top within a pixel.
[[nodiscard]] bool place_at_top(const ResponseWindow& window, int row, int column, CornerShape& shape);

}  // namespace srd::dsp
