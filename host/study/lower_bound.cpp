// SPDX-License-Identifier: Apache-2.0
#include "host/study/lower_bound.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "dsp/pipeline/prediction.hpp"

namespace srd::study {

Result<dsp::InformationMatrix<double>> information_bound(const Tank& tank, std::size_t view, const dsp::Coefficients<double>& a,
                                                         double sigma_px, std::span<const int> seen) {
  const int modes = tank.model.modes.size();
  dsp::InformationMatrix<double> information = dsp::InformationMatrix<double>::Zero(modes, modes);
  const dsp::View<double>& camera = tank.views[view];
  const auto add = [&](const dsp::Vec3<double>& point) -> Result<void, Errc> {
    const auto start = camera.normalised(point);
    if (!start) return start.error();
    dsp::Trace<double> trace;
    dsp::Mat2<double> b_xy;
    const auto xy = dsp::see_through(camera, tank.model, a, tank.media, point, *start, trace, b_xy);
    if (!xy) return xy.error();
    const auto prediction = dsp::predict(camera, tank.model, a, tank.media, point, *xy);
    if (!prediction) return prediction.error();
    dsp::Basis<double> basis;
    tank.model.basis(trace.surface_point.x(), trace.surface_point.y(), basis);
    // The point stays where it is when a changes: dq = -(dq/db) db/da.
    Eigen::Matrix<double, 2, Eigen::Dynamic> jacobian(2, modes);
    for (int j = 0; j < modes; ++j)
      jacobian.col(j) = -prediction->pixel_per_mm *
                        (trace.d_height * basis.value[j] + trace.d_slope * dsp::Vec2<double>(basis.dx[j], basis.dy[j]));
    information += jacobian.transpose() * jacobian / (sigma_px * sigma_px);
    return {};
  };
  if (seen.empty()) {
    for (const auto& point : tank.points)
      if (const auto added = add(point); !added) return added.error();
  } else {
    for (const int i : seen)
      if (const auto added = add(tank.points[static_cast<std::size_t>(i)]); !added) return added.error();
  }
  return information;
}

Result<double> surface_bound(const Tank& tank, const dsp::InformationMatrix<double>& information) {
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (factor.info() != Eigen::Success) return Errc::kSingular;
  double sum = 0;
  for (const auto& point : tank.points) {
    dsp::Basis<double> basis;
    tank.model.basis(point.x(), point.y(), basis);
    const Eigen::VectorXd modes = basis.value;
    sum += modes.dot(factor.solve(modes));
  }
  return std::sqrt(sum / static_cast<double>(tank.points.size()));
}

double surface_error(const Tank& tank, const dsp::Coefficients<double>& a, const dsp::Coefficients<double>& truth) {
  double sum = 0;
  for (const auto& point : tank.points) {
    const double e = tank.model.height(a, point.x(), point.y()) - tank.model.height(truth, point.x(), point.y());
    sum += e * e;
  }
  return std::sqrt(sum / static_cast<double>(tank.points.size()));
}

double corner_bound(double contrast, double blur_px, double noise, int half_window) {
  const double blur = std::sqrt(blur_px * blur_px + 1.0 / 12);
  return noise * std::sqrt(2 * std::sqrt(M_PI) * blur / (2 * half_window + 1)) / contrast;
}

}  // namespace srd::study
