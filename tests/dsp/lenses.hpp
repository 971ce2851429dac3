// SPDX-License-Identifier: Apache-2.0
// Lenses that the tests of the camera model share.
#pragma once

#include <vector>

#include "dsp/optics/camera_model.hpp"

namespace srd::dsp {

struct Lens {
  double fx, fy, cx, cy;
  std::vector<double> distortion;
  double field;  // largest normalised coordinate that its image holds
};

// Every length that OpenCV writes. The rational one is a real calibration whose numerator and denominator
// nearly cancel.
inline std::vector<Lens> lenses() {
  return {
      {2150, 2150, 648, 315, {}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01}, 0.32},
      {2150, 2140, 648, 315, {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01, 2e-3, -1e-3, 3e-3, 1e-3}, 0.32},
      {2150,
       2140,
       648,
       315,
       {-0.21, 0.09, -0.004, -0.0035, 0.3, 0.05, -0.02, 0.01, 2e-3, -1e-3, 3e-3, 1e-3, 0.02, -0.03},
       0.32},
      {3677.2454479896355,
       3691.2551717542042,
       861.39701539762382,
       579.07482041753951,
       {5.6299665198342461e+02, 3.6617556466798925e+02, -4.0019866575092622e-03, -3.3448739522447973e-03,
        -1.0574361556358065e+03, 5.6096566458243137e+02, 5.1134300014322565e+02, -1.2666510698168281e+03, 0, 0, 0, 0, 0, 0},
       0.28},
  };
}

template <class S>
CameraModel<S> camera_of(const Lens& lens) {
  return CameraModel<S>::make(lens.fx, lens.fy, lens.cx, lens.cy, lens.distortion).value();
}

}  // namespace srd::dsp
