// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/cost_solver.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <limits>

namespace nav::registration {
namespace {

// Initial trust region. Where the curvature differs from Gauss–Newton's, a step is several times
// too long. A region that is too large then costs rejected steps, each one evaluation, until it is
// small enough.
constexpr double kFirstTrustRegion = 3;

class Watch final : public ceres::IterationCallback {
 public:
  Watch(const SolveLimits& limits, const std::function<bool()>& keep_going)
      : limits_(limits), keep_going_(keep_going) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
    if (keep_going_ && !keep_going_()) {
      cancelled = true;
      return ceres::SOLVER_ABORT;
    }
    converged = step.iteration > 0 && step.step_is_valid &&
                gain_of(step) <= limits_.cost_tolerance * step.cost;
    if (converged || (limits_.late && limits_.late())) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    return ceres::SOLVER_CONTINUE;
  }
  bool cancelled = false;
  bool converged = false;

 private:
  /// The gain of an accepted step, or the predicted gain of a rejected one. Ceres itself compares
  /// the loss that a rejected step would have caused, which may be small by chance far from the
  /// minimum.
  static double gain_of(const ceres::IterationSummary& step) {
    if (step.step_is_successful) return step.cost_change;
    return step.relative_decrease != 0 ? std::abs(step.cost_change / step.relative_decrease)
                                       : std::numeric_limits<double>::infinity();
  }

  const SolveLimits& limits_;
  const std::function<bool()>& keep_going_;
};

ceres::Solver::Options solver_options(const SolveLimits& limits) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = limits.max_iterations;
  options.num_threads = 1;  // The single residual block is parallel internally.
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 0;  // Watch checks it.
  options.initial_trust_region_radius = kFirstTrustRegion;
  options.gradient_tolerance = 1e-10;
  options.parameter_tolerance = 1e-5;
  // Steps that are too long are rejected by their cost; each rejection shrinks the trust region
  // faster.
  options.max_num_consecutive_invalid_steps = 20;
  return options;
}

Termination termination_of(ceres::TerminationType type, bool converged) {
  if (converged || type == ceres::CONVERGENCE) return Termination::kConverged;
  if (type == ceres::USER_SUCCESS) return Termination::kTimeLimit;
  if (type == ceres::NO_CONVERGENCE) return Termination::kIterationLimit;
  return Termination::kFailed;
}

}  // namespace

CostSolution minimise(ceres::CostFunction* residuals, Eigen::Ref<Eigen::VectorXd> delta,
                      const SolveLimits& limits, const std::function<bool()>& keep_going) {
  delta.setZero();
  ceres::Problem problem;
  problem.AddResidualBlock(residuals, nullptr, delta.data());
  ceres::Solver::Options options = solver_options(limits);
  Watch watch(limits, keep_going);
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const bool usable = summary.IsSolutionUsable() && delta.allFinite();
  if (!usable) delta.setZero();
  std::string message = watch.converged ? "a step gains less than the tolerance" : summary.message;
  std::replace(message.begin(), message.end(), '\n', ' ');
  // Ceres counts ½‖R‖²; its costs are -1 if it never computed one.
  const double initial = summary.initial_cost >= 0 ? 2 * summary.initial_cost : 1.0;
  const double last = usable && summary.final_cost >= 0 ? 2 * summary.final_cost : initial;
  return {.initial_cost = initial,
          .final_cost = last,
          .iterations = std::max(static_cast<int>(summary.iterations.size()) - 1, 0),
          .termination = termination_of(summary.termination_type, watch.converged),
          .message = message,
          .cancelled = watch.cancelled};
}

}  // namespace nav::registration
