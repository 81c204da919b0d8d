// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/pose_solver.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <optional>

#include "registration/cost_solver.hpp"
#include "registration/secant_curvature.hpp"

namespace nav::registration {
namespace {

/// Equation: R(δ)ᵀR(δ) = E(moved(start, c, δ)); 7 residuals, dimensionless; δ = [60 ω | t] mm.
class TwistCost final : public ceres::SizedCostFunction<7, 6> {
 public:
  TwistCost(const SimilarityCost& cost, const Pose& start, const Eigen::Vector3d& centre,
            int& non_finite)
      : cost_(cost), start_(start), centre_(centre), non_finite_(non_finite) {}

  static Vector6d twist_of(const double* delta) {
    Vector6d twist = Eigen::Map<const Vector6d>(delta);
    twist.head<3>() /= kRotationScaleMm;
    return twist;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector6d> delta(parameters[0]);
    if (!delta.allFinite() || delta.norm() > kMaxTravelMm) return false;
    const Vector6d twist = twist_of(parameters[0]);
    const Pose pose = moved(start_, centre_, twist);
    Eigen::Map<Eigen::Matrix<double, 7, 1>> r(residuals);
    r.setZero();
    const bool again = tried_ && *tried_ == delta;
    if (!again) {
      // Most tried steps are accepted, and Ceres then asks for their derivatives.
      terms_ = cost_.terms(pose, centre_ + twist.tail<3>());
      tried_ = delta;
    }
    const CostTerms& terms = terms_;
    non_finite_ = std::max(non_finite_, terms.non_finite);
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      r[6] = std::sqrt(terms.cost);
      return std::isfinite(terms.cost);
    }
    if (!std::isfinite(terms.cost) || !terms.hessian.allFinite()) return false;
    fill(terms, delta, r, Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobians[0]));
    return true;
  }

 private:
  void fill(const CostTerms& terms, const Vector6d& delta,
            Eigen::Map<Eigen::Matrix<double, 7, 1>> r,
            Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> jacobian) const {
    const Vector6d twist = twist_of(delta.data());
    // Derivative of the twist itself: a left increment about the moved centre.
    Matrix6d chain = Matrix6d::Identity();
    chain.topLeftCorner<3, 3>() = left_jacobian(twist.head<3>()) / kRotationScaleMm;
    const Vector6d g = chain.transpose() * terms.gradient;
    const Matrix6d h = curvature_.corrected(delta, g, chain.transpose() * terms.hessian * chain);
    fill_residuals(terms.cost, g, h, r, jacobian);
  }

  const SimilarityCost& cost_;
  Pose start_;
  Eigen::Vector3d centre_;
  int& non_finite_;
  mutable std::optional<Vector6d> tried_;
  mutable CostTerms terms_;  // Terms at tried_.
  mutable SecantCurvature<6>
      // Ceres asks for Jacobians on one thread, once for each accepted step.
      curvature_;
};

}  // namespace

PoseSolution solve_pose(const SimilarityCost& cost, const Pose& start,
                        const Point<frames::Reference>& centroid, const SolveLimits& limits,
                        const std::function<bool()>& keep_going) {
  const Eigen::Vector3d centre = (start * centroid).mm;
  int non_finite = 0;
  Eigen::VectorXd delta(6);
  auto* residuals = new TwistCost(cost, start, centre, non_finite);  // Ceres takes ownership.
  const CostSolution found = minimise(residuals, delta, limits, keep_going);
  return solution_at(moved(start, centre, TwistCost::twist_of(delta.data())), found, non_finite);
}

}  // namespace nav::registration
