// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/ceres_solve.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/LU>
#include <limits>

namespace srd::bench {

namespace {

using dsp::Mat2;
using dsp::Mat3;
using dsp::Vec2;
using dsp::Vec3;
constexpr int kModes = 12;

struct Setting {
  dsp::View<double> view;
  dsp::SurfaceModel<double> model;
  double ratio;  // index of air over that of water
};

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Vector2 = Eigen::Matrix<T, 2, 1>;

// Newton for the foot runs in double from where the last evaluation ended; one step with derivatives follows, which by
// the implicit function theorem gives foot and its derivatives. Less work for automatic differentiation than the
// whole iteration.
class Reprojection {
 public:
  Reprojection(const Setting& setting, const Vec3<double>& point, const dsp::Observation<double>& corner)
      : setting_(setting), point_(point), pixel_(corner.pixel), weight_(1 / corner.sigma) {
    foot_ = point.head<2>();
  }

  template <class T>
  bool operator()(const T* a, T* e) const {
    dsp::Coefficients<double> numbers(kModes);
    for (int j = 0; j < kModes; ++j) numbers[j] = number(a[j]);
    Mat2<double> inverse;
    for (int i = 0; i < 20; ++i) {
      const Vec2<double> step = inverse_map(numbers, inverse);
      foot_ += step;
      if (!step.allFinite()) return false;
      if (step.norm() < 1e-9) break;
    }
    dsp::Basis<double> basis;
    setting_.model.basis(foot_.x(), foot_.y(), basis);
    T z(0.0), zx(0.0), zy(0.0);
    for (int j = 0; j < kModes; ++j) {
      z += a[j] * basis.value[j];
      zx += a[j] * basis.dx[j];
      zy += a[j] * basis.dy[j];
    }
    const Vector2<T> miss = bottom(Vector2<T>(T(foot_.x()), T(foot_.y())), z, zx, zy) - point_.head<2>().cast<T>();
    const Vector2<T> correction = -(inverse.cast<T>() * miss);
    const Vector2<T> foot = foot_.cast<T>() + correction;
    const Vector3<T> p(foot.x(), foot.y(), z + zx * correction.x() + zy * correction.y());
    const Vector3<T> c = setting_.view.pose.rotation.cast<T>() * p + setting_.view.pose.translation.cast<T>();
    const T x = c.x() / c.z(), y = c.y() / c.z(), r2 = x * x + y * y;
    const auto& camera = setting_.view.camera;
    const auto& k = camera.distortion();
    const T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const T xd = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
    const T yd = y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
    e[0] = weight_ * (camera.fx() * xd + camera.cx() - pixel_.x());
    e[1] = weight_ * (camera.fy() * yd + camera.cy() - pixel_.y());
    return true;
  }

 private:
  static double number(double x) { return x; }
  template <class Jet>
  static double number(const Jet& x) {
    return x.a;
  }

  // Optics (7), (8): where the ray through the surface point above foot reaches the bottom.
  template <class T>
  Vector2<T> bottom(const Vector2<T>& foot, const T& z, const T& zx, const T& zy) const {
    using std::sqrt;
    const Vec3<double> centre = setting_.view.pose.centre();
    const Vector3<T> ray(foot.x() - centre.x(), foot.y() - centre.y(), z - centre.z());
    const Vector3<T> d = ray / sqrt(ray.squaredNorm());
    const Vector3<T> m(-zx, -zy, T(1.0));
    const Vector3<T> n = m / sqrt(m.squaredNorm());
    const T ci = -d.dot(n);
    const double r = setting_.ratio;
    const Vector3<T> v = r * d + (r * ci - sqrt(1.0 - r * r * (1.0 - ci * ci))) * n;
    const T s = (point_.z() - z) / v.z();
    return foot + s * v.template head<2>();
  }

  // A Newton step for the foot; derivatives by differences of the map, which are good enough to converge on.
  Vec2<double> inverse_map(const dsp::Coefficients<double>& a, Mat2<double>& inverse) const {
    constexpr double kStep = 1e-5;  // mm
    const auto at = [&](const Vec2<double>& foot) -> Vec2<double> {
      const auto sample = setting_.model.sample(a, foot.x(), foot.y());
      return bottom<double>(foot, sample.z, sample.zx, sample.zy);
    };
    const Vec2<double> here = at(foot_);
    Mat2<double> by_foot;
    by_foot.col(0) = (at(foot_ + Vec2<double>(kStep, 0)) - here) / kStep;
    by_foot.col(1) = (at(foot_ + Vec2<double>(0, kStep)) - here) / kStep;
    inverse = by_foot.inverse();
    return -(inverse * (here - point_.head<2>()));
  }

  const Setting& setting_;
  Vec3<double> point_;
  Vec2<double> pixel_;
  double weight_;
  mutable Vec2<double> foot_;
};

}  // namespace

struct CeresSolve::State {
  Setting setting;
  std::array<double, kModes> a{};
  ceres::Problem problem;
};

CeresSolve::CeresSolve(const dsp::View<double>& view, const dsp::SurfaceModel<double>& model, const dsp::Media<double>& media,
                       std::span<const Vec3<double>> points, std::span<const dsp::Observation<double>> corners)
    : state_(std::make_unique<State>()) {
  state_->setting = {view, model, media.air / media.water};
  for (const auto& corner : corners)
    state_->problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, kModes>(new Reprojection(
                                         state_->setting, points[static_cast<std::size_t>(corner.point)], corner)),
                                     nullptr, state_->a.data());
}

CeresSolve::~CeresSolve() = default;

double CeresSolve::solve(dsp::Coefficients<double>& coefficients) {
  for (int j = 0; j < kModes; ++j) state_->a[static_cast<std::size_t>(j)] = coefficients[j];
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &state_->problem, &summary);
  for (int j = 0; j < kModes; ++j) coefficients[j] = state_->a[static_cast<std::size_t>(j)];
  return summary.IsSolutionUsable() ? 2 * summary.final_cost : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace srd::bench
