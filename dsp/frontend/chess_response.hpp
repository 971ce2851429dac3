// ChESS corner response (Bennett & Lasenby 2014). Optics (22). Scalar: the definition of correct.
// |sum response| <= 4 * 510 = 2040, difference response <= 8 * 255 = 2040, mean term <= 16 * 255 = 4080:
// the total lies in [-6120, 2040], and int16 has two bits to spare.
#pragma once

#include <cstdint>

#include "dsp/core/image_view.hpp"

namespace srd::dsp {

struct ResponseOptions {
  int radius = 5;          // px, 5 or 10
  bool mean_term = false;  // also subtract 16 |mean of the circle - mean of the centre cross|: rejects stripes
};

// The response at one pixel; (u, v) at least radius from every border.
[[nodiscard]] std::int16_t response_at(const GrayView& image, int u, int v, const ResponseOptions& options);

// Responses of pixels u0 <= u < u1 of row v into out[0 .. u1 - u0); all at least radius from every border.
void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out);

}  // namespace srd::dsp
