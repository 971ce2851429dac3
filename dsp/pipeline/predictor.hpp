// SPDX-License-Identifier: Apache-2.0
// Where one camera sees every point of the pattern through a given surface: several points at once, each from where it was
// found last. Sized at construction; no heap afterwards. One thread per object.
#pragma once

#include <span>
#include <vector>

#include "dsp/estimate/residual/observation.hpp"
#include "dsp/estimate/residual/sight_line.hpp"
#include "dsp/pipeline/prediction.hpp"

namespace srd::dsp {

template <class S>
class Predictor {
 public:
  Predictor(const View<S>& view, const SurfaceModel<S>& model, const Media<S>& media, std::span<const Vec3<S>> points);

  // All points through the surface a. Those that cannot be seen through it are marked.
  void predict(const Coefficients<S>& a);

  // Undistorted places of corners that were found near their predictions, several at once. Those outside the calibrated
  // field are taken out of the list.
  void undistort(std::vector<Observation<S>>& corners) const;

  [[nodiscard]] bool valid(std::size_t point) const { return valid_[point] != 0; }
  [[nodiscard]] const Prediction<S>& operator[](std::size_t point) const { return predictions_[point]; }

 private:
  using T = Lanes<S>;
  struct Group {
    SightLine<T> line;
    bool started = false;
  };

  // As if the light went straight on to the level of the constant mode.
  void start(const Coefficients<S>& a, SightLine<T>& line) const;
  // Pixels beyond the range of the front end's fixed point are nowhere near an image.
  [[nodiscard]] static char take(const Sighting<T>& seen, const SightLine<T>& line, int lane, Prediction<S>& out);
  // By Newton from the predictions. False: some corner is too far from its own for two steps.
  [[nodiscard]] bool undistort_together(std::span<Observation<S>> few) const;
  // Where one point of a group cannot be seen, the others still may.
  [[nodiscard]] char alone(const Coefficients<S>& a, std::size_t i);

  View<S> view_;
  Media<S> media_;
  SurfaceModel<S> model_;
  View<T> wide_view_;
  Optics<T> optics_;
  std::vector<Vec3<S>> points_;
  std::vector<Prediction<S>> predictions_;
  std::vector<char> valid_;
  std::vector<Group> groups_;
};

extern template class Predictor<float>;
extern template class Predictor<double>;

}  // namespace srd::dsp
