// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/cost_solver.hpp"

#include <ceres/ceres.h>

namespace nav::registration {
namespace {

class AskToGoOn final : public ceres::IterationCallback {
 public:
  AskToGoOn(const std::function<bool()>& keep_going, const std::function<bool()>& late)
      : keep_going_(keep_going), late_(late) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    if (keep_going_ && !keep_going_()) {
      cancelled = true;
      return ceres::SOLVER_ABORT;
    }
    return late_ && late_() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  bool cancelled = false;

 private:
  const std::function<bool()>& keep_going_;
  const std::function<bool()>& late_;
};

ceres::Solver::Options solver_options(const SolveLimits& limits) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = limits.max_iterations;
  options.num_threads = 1;  // The one residual block is parallel inside.
  options.logging_type = ceres::SILENT;
  options.function_tolerance = limits.cost_tolerance;
  options.gradient_tolerance = 1e-10;
  options.parameter_tolerance = 1e-5;
  // Too long steps are refused by the cost; each halves the trust region faster.
  options.max_num_consecutive_invalid_steps = 20;
  return options;
}

Termination termination_of(ceres::TerminationType type) {
  if (type == ceres::CONVERGENCE) return Termination::kConverged;
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
  AskToGoOn callback(keep_going, limits.late);
  options.callbacks.push_back(&callback);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const bool usable = summary.IsSolutionUsable() && delta.allFinite();
  if (!usable) delta.setZero();
  std::string message = summary.message;
  std::replace(message.begin(), message.end(), '\n', ' ');
  // Ceres counts ½‖R‖²; its costs are -1 where it never got one.
  const double initial = summary.initial_cost >= 0 ? 2 * summary.initial_cost : 1.0;
  const double last = usable && summary.final_cost >= 0 ? 2 * summary.final_cost : initial;
  return {initial,
          last,
          std::max(static_cast<int>(summary.iterations.size()) - 1, 0),
          termination_of(summary.termination_type),
          message,
          callback.cancelled};
}

}  // namespace nav::registration
