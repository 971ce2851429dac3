// SPDX-License-Identifier: Apache-2.0
// Covariance of everything that a Ceres problem leaves free, from its Jacobian at the solution.
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/core/result.hpp"

namespace srd::bundle {

struct Block {
  double* values = nullptr;
  int size = 0;
};

// What the data do not determine: the direction in the scaled parameters with the least information.
struct Weakness {
  double least = 0;             // eigenvalue of the scaled information, 0 to 1; 1: no parameter leans on another
  Eigen::VectorXd direction{};  // unit, one number a parameter, each parameter in its own unscaled deviation
};

struct Covariance {
  Eigen::MatrixXd matrix;  // of the blocks in the order given, for residuals of variance 1
  Weakness weakness;
};

// Blocks that are constant in the problem are not to be given. kSingular where the scaled information has an
// eigenvalue below 1e-13: then at least one parameter is not determined. The work grows with the cube of the
// parameters: 120 take a millisecond, 500 a tenth of a second.
[[nodiscard]] Result<Covariance> covariance(ceres::Problem& problem, const std::vector<Block>& blocks);

}  // namespace srd::bundle
