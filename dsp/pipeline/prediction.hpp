// SPDX-License-Identifier: Apache-2.0
// Where a corner of the pattern should be seen through a given surface, and how its edges should run. Optics (8).
#pragma once

#include "dsp/frontend/corner_fit.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace srd::dsp {

template <class S>
struct Prediction {
  Vec2<S> normalised;    // undistorted; the start of the next prediction
  Vec2<S> pixel;         // raw image, px
  Mat2<S> pixel_per_mm;  // d pixel / d (X, Y) of the point: its columns are the edges' directions
  Vec2<S> foot;          // where the sight line crosses the surface, from the point, mm
};

// start: normalised coordinates near the answer. Errors: as see_through.
template <class S>
[[nodiscard]] Result<Prediction<S>> predict(const View<S>& view, const SurfaceModel<S>& model, const Coefficients<S>& a,
                                            const Media<S>& media, const Vec3<S>& point, const Vec2<S>& start) {
  Trace<S> trace;
  Mat2<S> bottom_per_normalised;
  const Result<Vec2<S>> seen = see_through(view, model, a, media, point, start, trace, bottom_per_normalised);
  if (!seen) return seen.error();
  Prediction<S> out;
  Mat2<S> pixel_per_normalised;
  out.normalised = *seen;
  out.pixel = view.camera.pixel(*seen, &pixel_per_normalised);
  const Mat2<S>& b = bottom_per_normalised;
  const S det = b(0, 0) * b(1, 1) - b(0, 1) * b(1, 0);
  Mat2<S> inverse;
  inverse << b(1, 1) / det, -b(0, 1) / det, -b(1, 0) / det, b(0, 0) / det;
  out.pixel_per_mm = pixel_per_normalised * inverse;
  out.foot = (trace.surface_point - point).template head<2>();
  // Pixels beyond the range of the front end's fixed point are nowhere near an image.
  if (!(out.pixel.cwiseAbs().maxCoeff() < S(100000)) || !out.pixel_per_mm.allFinite()) return Errc::kOutOfDomain;
  return out;
}

// The corner's shape as the fit wants it. bright: the square towards +X +Y of the corner is bright.
template <class S>
[[nodiscard]] CornerShape expected_shape(const Prediction<S>& prediction, bool bright, std::int32_t blur_q12) {
  const auto normal_of = [](const Vec2<S>& edge) {
    const Vec2<S> n = edge / edge.norm();
    return Direction{static_cast<std::int32_t>(std::lround(-n.y() * S(16384))),
                     static_cast<std::int32_t>(std::lround(n.x() * S(16384)))};
  };
  CornerShape shape;
  shape.u = Pixel::from_real(prediction.pixel.x());
  shape.v = Pixel::from_real(prediction.pixel.y());
  shape.n1 = normal_of(prediction.pixel_per_mm.col(0));
  shape.n2 = normal_of(prediction.pixel_per_mm.col(1));
  // Towards +X +Y the two distances have opposite signs: a bright square there needs one normal turned.
  if (bright) shape.n2 = {-shape.n2.x, -shape.n2.y};
  shape.blur_q12 = blur_q12;
  return shape;
}

// Bright or dark towards +X +Y, read off a corner that was found where prediction expects it.
template <class S>
[[nodiscard]] bool is_bright(const Prediction<S>& prediction, const CornerShape& found) {
  const Vec2<S> x = prediction.pixel_per_mm.col(0).normalized(), y = prediction.pixel_per_mm.col(1).normalized();
  const Vec2<S> towards = x + y;
  const auto side = [&](const Direction& n) {
    return static_cast<S>(n.x) * towards.x() + static_cast<S>(n.y) * towards.y() > S(0);
  };
  return side(found.n1) == side(found.n2);
}

extern template Result<Prediction<float>> predict(const View<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                                  const Media<float>&, const Vec3<float>&, const Vec2<float>&);
extern template Result<Prediction<double>> predict(const View<double>&, const SurfaceModel<double>&,
                                                   const Coefficients<double>&, const Media<double>&, const Vec3<double>&,
                                                   const Vec2<double>&);
extern template CornerShape expected_shape(const Prediction<float>&, bool, std::int32_t);
extern template CornerShape expected_shape(const Prediction<double>&, bool, std::int32_t);
extern template bool is_bright(const Prediction<float>&, const CornerShape&);
extern template bool is_bright(const Prediction<double>&, const CornerShape&);

}  // namespace srd::dsp
