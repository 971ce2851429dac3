// SPDX-License-Identifier: Apache-2.0
// What an estimate is made from: corners with identities, seen by calibrated cameras.
#pragma once

#include <limits>
#include <span>

#include "dsp/core/linear_algebra.hpp"
#include "dsp/optics/view.hpp"

namespace srd::dsp {

// One corner whose identity is known.
template <class S>
struct Observation {
  int point = 0;       // index into the bottom points
  Vec2<S> pixel;       // raw image, px
  Vec2<S> normalised;  // the same corner undistorted: CameraModel::undistort(pixel)
  S sigma = 1;         // standard deviation per axis, px; weights are 1/sigma
  // Where the prediction of this corner crossed the surface, from its bottom point, mm; NaN: not known. Saves the solver
  // a search, and changes nothing else.
  Vec2<S> foot = Vec2<S>::Constant(std::numeric_limits<S>::quiet_NaN());
};

// All corners of one camera in one frame.
template <class S>
struct CameraObservations {
  const View<S>* view = nullptr;
  std::span<const Observation<S>> corners;
};

}  // namespace srd::dsp
