// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "nav/matrices.hpp"
#include "registration/image_registration.hpp"

namespace ceres {
class CostFunction;
}

/// Common parts of every refinement of a cost E >= 0 by Ceres.
namespace nav::registration {

/// Residuals r and their Jacobian for a cost E with n parameters, with the gradient g of E/2 and
/// the Gauss–Newton Hessian H = QΛQᵀ. The n + 1 residuals r = [Λ^{−½}Qᵀg; √(E − gᵀH⁺g)] and the
/// Jacobian [Λ^{½}Qᵀ; 0] have the same normal equations as all samples together, and rᵀr = E.
/// Directions with less than 1e-9 of the greatest curvature are left out: they carry only the
/// rounding noise of the float kernel.
template <class Gradient, class Hessian, class Residuals, class Jacobian>
void fill_residuals(double cost, const Gradient& gradient, const Hessian& hessian, Residuals& r,
                    Jacobian& jacobian) {
  constexpr double kMinCurvatureRatio = 1e-9;
  const Eigen::Index n = gradient.size();
  const auto eigen = eigenpairs<Hessian::RowsAtCompileTime>(hessian);
  const double floor = kMinCurvatureRatio * std::max(eigen.values[n - 1], 0.0);
  r.setZero();
  jacobian.setZero();
  double explained = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double lambda = eigen.values[i];
    if (!(lambda > floor)) continue;
    const double root = std::sqrt(lambda);
    r[i] = eigen.vectors.col(i).dot(gradient) / root;
    jacobian.row(i) = root * eigen.vectors.col(i).transpose();
    explained += r[i] * r[i];
  }
  r[n] = std::sqrt(std::max(cost - explained, 0.0));
}

/// When a solve is finished. A relative change t of the cost moves a pose by about 6 mm·sqrt(t).
struct SolveLimits {
  int max_iterations;  ///< >= 0.
  /// The solve is finished when a step lowers the cost by less than this fraction, or when a
  /// rejected step predicted less than this fraction; > 0.
  double cost_tolerance = 3e-6;
  /// Asked before each step: true ends the solve with the best result so far (kTimeLimit). Empty:
  /// never.
  std::function<bool()> late = {};
};

/// A minimum and how it was found.
struct CostSolution {
  double initial_cost;
  double final_cost;  ///< 1 if the cost was never finite.
  int iterations;
  Termination termination;
  std::string message;
  bool cancelled;
};

/// Levenberg–Marquardt by Ceres on one residual block from delta = 0. delta stays 0 if no usable
/// result was found. Takes ownership of the residuals; their sum of squares is the cost.
/// keep_going: asked once per iteration; false stops the solve and sets cancelled.
CostSolution minimise(ceres::CostFunction* residuals, Eigen::Ref<Eigen::VectorXd> delta,
                      const SolveLimits& limits, const std::function<bool()>& keep_going);

}  // namespace nav::registration
