// SPDX-License-Identifier: Apache-2.0
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "dsp/optics/camera_model.hpp"
#include "host/bundle/corner_costs.hpp"
#include "host/bundle/covariance.hpp"
#include "host/bundle/lens.hpp"
#include "host/bundle/rigid.hpp"

namespace srd::bundle {
namespace {

constexpr std::array<int, 5> kCounts{4, 5, 8, 12, 14};

std::vector<double> some_lens(int coefficients) {
  std::vector<double> all{1400, 1390, 640,   500,  -0.21, 0.11, 1e-3,  -2e-3, 0.05,
                          0.02, 0.01, -0.03, 1e-3, -2e-3, 2e-3, -1e-3, 0.02,  -0.03};
  all.resize(static_cast<std::size_t>(kPinhole + coefficients));
  return all;
}

// Derivative of f for x[i], central, with a step that leaves 1e-8 of it.
template <class F>
Eigen::VectorXd difference(std::vector<double> x, std::size_t i, F f) {
  const double step = 1e-5 * std::max(std::abs(x[i]), 0.1), at = x[i];
  x[i] = at + step;
  const Eigen::VectorXd above = f(x);
  x[i] = at - step;
  return (above - f(x)) / (2 * step);
}

TEST(BundleLens, ProjectsAsTheCameraModelOfTheOpticsPage) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(-0.4, 0.4);
  for (const int n : kCounts) {
    const std::vector<double> lens = some_lens(n);
    const auto model = dsp::CameraModel<double>::make(lens[0], lens[1], lens[2], lens[3], std::span(lens).subspan(kPinhole));
    ASSERT_TRUE(model.ok());
    for (int draw = 0; draw < 50; ++draw) {
      const Eigen::Vector3d point = Eigen::Vector3d(side(random), side(random), 1) * 700;
      Eigen::Vector2d pixel;
      ASSERT_TRUE(project(lens, point, pixel));
      EXPECT_LT((pixel - model->pixel(point.head<2>() / point.z())).norm(), 1e-9);
    }
  }
}

TEST(BundleLens, APointBehindTheCameraHasNoPixel) {
  Eigen::Vector2d pixel(7, 8);
  EXPECT_FALSE(project(some_lens(5), {1, 2, -3}, pixel));
  EXPECT_FALSE(project(some_lens(5), {1, 2, 0}, pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(7, 8));
}

TEST(BundleLens, DerivativesAgreeWithCentralDifferences) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> side(-0.4, 0.4);
  for (const int n : kCounts) {
    const std::vector<double> lens = some_lens(n);
    for (int draw = 0; draw < 20; ++draw) {
      const std::vector<double> point{700 * side(random), 700 * side(random), 700};
      const auto at = [](const std::vector<double>& k, const std::vector<double>& p) {
        Eigen::Vector2d pixel;
        EXPECT_TRUE(project(k, Eigen::Map<const Eigen::Vector3d>(p.data()), pixel));
        return Eigen::VectorXd(pixel);
      };
      IntrinsicsJacobian by_lens;
      Eigen::Matrix<double, 2, 3> by_point;
      Eigen::Vector2d pixel;
      ASSERT_TRUE(project(lens, Eigen::Map<const Eigen::Vector3d>(point.data()), pixel, &by_lens, &by_point));
      for (std::size_t i = 0; i < lens.size(); ++i) {
        const Eigen::VectorXd d = difference(lens, i, [&](const auto& k) { return at(k, point); });
        EXPECT_LT((by_lens.col(static_cast<int>(i)) - d).norm(), 1e-6 * (1 + d.norm())) << intrinsic_name(static_cast<int>(i));
      }
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::VectorXd d = difference(point, i, [&](const auto& p) { return at(lens, p); });
        EXPECT_LT((by_point.col(static_cast<int>(i)) - d).norm(), 1e-6 * (1 + d.norm())) << i;
      }
    }
  }
}

TEST(BundlePose, SixNumbersAndBack) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const double size : {0.0, 1e-7, 1e-5, 1e-3, 0.5, 3.0}) {
    PoseVector p;
    for (int i = 0; i < kPose; ++i) p[i] = normal(random);
    p.head<3>() *= size / p.head<3>().norm();
    const dsp::Pose<double> pose = to_pose(p);
    EXPECT_LT((pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_LT((to_vector(pose) - p).norm(), 1e-8 * (1 + size));
    if (size == 0) continue;
    EXPECT_LT((pose.rotation - Eigen::AngleAxisd(size, p.head<3>() / size).toRotationMatrix()).norm(), 1e-14);
  }
}

// Every block of every cost, at small, usual and large turns.
template <class Cost>
void expect_derivatives(const Cost& cost, std::vector<std::vector<double>> blocks) {
  std::array<double, 2> residual{};
  std::vector<std::vector<double>> jacobians;
  std::vector<double*> into;
  std::vector<const double*> values;
  for (const auto& block : blocks) {
    values.push_back(block.data());
    jacobians.emplace_back(2 * block.size());
  }
  for (auto& jacobian : jacobians) into.push_back(jacobian.data());
  ASSERT_TRUE(cost.Evaluate(values.data(), residual.data(), into.data()));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t i = 0; i < blocks[b].size(); ++i) {
      const Eigen::VectorXd d = difference(blocks[b], i, [&](const std::vector<double>& x) {
        std::vector<const double*> moved = values;
        moved[b] = x.data();
        std::array<double, 2> r{};
        EXPECT_TRUE(cost.Evaluate(moved.data(), r.data(), nullptr));
        return Eigen::VectorXd(Eigen::Map<Eigen::Vector2d>(r.data()));
      });
      const Eigen::Vector2d analytic(jacobians[b][i], jacobians[b][blocks[b].size() + i]);
      EXPECT_LT((analytic - d).norm(), 2e-6 * (1 + d.norm())) << "block " << b << ", number " << i;
    }
  }
}

TEST(BundleCosts, DerivativesAgreeWithCentralDifferences) {
  const BoardShape shape{7, 17, 9.75};
  for (const int n : kCounts) {
    for (const std::array<double, 3>& turn :
         {std::array{0.0, 0.0, 1e-9}, std::array{3e-5, -2e-5, 5e-5}, std::array{0.3, -0.5, 1.2}, std::array{2.0, 1.5, -1.2}}) {
      const std::vector<double> pose{turn[0], turn[1], turn[2], -30, -20, 600};
      expect_derivatives(PointCost({{600, 500}, 0.05}, n), {some_lens(n), pose, {40, 25, 3}});
      expect_derivatives(BoardCost({{600, 500}, 0.05}, n, shape, 2, 5), {some_lens(n), pose, {0.3, -0.2}});
    }
  }
}

TEST(BundleCovariance, IsThatOfAStraightLine) {
  // y = a + b x by least squares: the covariance is known in closed form.
  struct Line : ceres::SizedCostFunction<1, 1, 1> {
    explicit Line(double at) : x(at) {}
    bool Evaluate(double const* const* p, double* r, double** j) const override {
      r[0] = p[0][0] + p[1][0] * x - 2;
      if (j != nullptr && j[0] != nullptr) j[0][0] = 1;
      if (j != nullptr && j[1] != nullptr) j[1][0] = x;
      return true;
    }
    double x;
  };
  double a = 2, b = 0;
  ceres::Problem problem;
  double n = 0, sx = 0, sxx = 0;
  for (int i = 0; i < 9; ++i) {
    const double x = 3 + i;
    problem.AddResidualBlock(new Line(x), nullptr, &a, &b);
    n += 1;
    sx += x;
    sxx += x * x;
  }
  const auto found = covariance(problem, {{&a, 1}, {&b, 1}});
  ASSERT_TRUE(found.ok());
  const double determinant = n * sxx - sx * sx;
  EXPECT_NEAR(found->matrix(0, 0), sxx / determinant, 1e-12);
  EXPECT_NEAR(found->matrix(1, 1), n / determinant, 1e-12);
  EXPECT_NEAR(found->matrix(0, 1), -sx / determinant, 1e-12);
  EXPECT_NEAR(found->weakness.least, 1 - sx / std::sqrt(n * sxx), 1e-12);
}

TEST(BundleCovariance, ParametersThatNothingTellsApartAreSingular) {
  std::vector<double> lens = some_lens(4), pose{0, 0, 0, 0, 0, 600}, point{0, 0, 0};
  ceres::Problem problem;
  problem.AddResidualBlock(new PointCost({{640, 500}, 0.1}, 4), nullptr, lens.data(), pose.data(), point.data());
  const auto found = covariance(problem, {{lens.data(), 8}, {pose.data(), 6}, {point.data(), 3}});
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error(), Errc::kSingular);
}

}  // namespace
}  // namespace srd::bundle
