// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_solver.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <numeric>

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

// Median of |normal| over its standard deviation.
constexpr double kMadToSigma = 1.4826;
// Huber: 95 % as efficient as least squares for normally distributed noise.
constexpr double kHuberSigmas = 1.345;
constexpr int kIterationsPerRound = 5;
constexpr double kStillMm = 1e-3;
constexpr double kMaxShapeTravelMm = 100;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Offset of a point at a pose, and its derivative by a twist about a centre.
struct Placed {
  Eigen::Vector3d offset;
  Matrix36d by_twist;
};

Placed place(const ShapeField& shape, const Eigen::Vector3d& p, const Eigen::Vector3d& centre) {
  const ShapeSample sample = shape.at(p);
  Matrix36d motion;
  motion << -cross_matrix(p - centre), Eigen::Matrix3d::Identity();
  return {sample.offset_mm, sample.by_point * motion};
}

/// Offset of one point in mm; parameters along the directions of an observability, mm.
class OffsetCost final : public ceres::SizedCostFunction<3, 6> {
 public:
  OffsetCost(const ShapeField& shape, const Point<frames::Reference>& point, const Pose& start,
             const Eigen::Vector3d& centre, const Matrix6d& twist_from_parameters)
      : shape_(shape),
        point_(point),
        start_(start),
        centre_(centre),
        twist_from_parameters_(twist_from_parameters) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector6d> z(parameters[0]);
    if (!z.allFinite() || z.norm() > kMaxShapeTravelMm) return false;
    const Vector6d twist = twist_from_parameters_ * z;
    const Eigen::Vector3d p = (moved(start_, centre_, twist) * point_).mm;
    const Placed placed = place(shape_, p, centre_ + twist.tail<3>());
    Eigen::Map<Eigen::Vector3d> r(residuals);
    r = placed.offset;
    if (jacobians == nullptr || jacobians[0] == nullptr) return r.allFinite();
    Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
    Matrix36d by_twist = placed.by_twist;
    by_twist.leftCols<3>() = (by_twist.leftCols<3>() * left_jacobian(twist.head<3>())).eval();
    jacobian = by_twist * twist_from_parameters_;
    return r.allFinite() && jacobian.allFinite();
  }

 private:
  const ShapeField& shape_;
  const Point<frames::Reference>& point_;
  const Pose& start_;
  const Eigen::Vector3d& centre_;
  const Matrix6d& twist_from_parameters_;
};

/// The nearest fraction of the points.
std::vector<std::size_t> nearest_share(const ReferencePoints& points, const ShapeField& shape,
                                       const Pose& pose, double share) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const auto& point : points) distances.push_back(shape.distance_mm((pose * point).mm));
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
  const auto kept = static_cast<std::size_t>(std::ceil(share * static_cast<double>(points.size())));
  order.resize(std::clamp<std::size_t>(kept, 1, points.size()));
  std::sort(order.begin(), order.end());
  return order;
}

double mean_of(const ReferencePoints& points, const ShapeField& shape, const Pose& pose,
               const std::vector<std::size_t>& counted) {
  double sum = 0;
  for (const std::size_t i : counted) sum += shape.distance_mm((pose * points[i]).mm);
  return sum / static_cast<double>(counted.size());
}

/// One round; returns the points' mean motion, mm.
double solve_round(const ReferencePoints& points, const ShapeField& shape, const ShapeCurvature& at,
                   const ShapeRegistrationOptions& options, ShapeSolution& solution) {
  const Observability seen = observability(at.curvature, at.lever_mm, options.least_strength);
  if (seen.unseen == 6) return 0;
  Matrix6d twist_from_parameters;
  for (Eigen::Index i = 0; i < 6; ++i) twist_from_parameters.col(i) = seen.twist(i);
  Vector6d z = Vector6d::Zero();
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::HuberLoss loss(kHuberSigmas * at.scale_mm);
  ceres::Problem problem(ownership);
  const Pose start = solution.pose;
  for (const std::size_t i : at.counted) {
    problem.AddResidualBlock(
        new OffsetCost(shape, points[i], start, at.centre_ct_mm, twist_from_parameters), &loss,
        z.data());
  }
  if (seen.unseen > 0) {
    std::vector<int> held(static_cast<std::size_t>(seen.unseen));
    std::iota(held.begin(), held.end(), 0);
    problem.SetManifold(z.data(), new ceres::SubsetManifold(6, held));
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.logging_type = ceres::SILENT;
  solver.max_num_iterations = kIterationsPerRound;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable() || !z.allFinite()) return 0;
  solution.iterations += std::max(static_cast<int>(summary.iterations.size()) - 1, 0);
  solution.pose = moved(start, at.centre_ct_mm, twist_from_parameters * z);
  return z.norm();
}

}  // namespace

ShapeCurvature curvature_at(const ReferencePoints& points, const ShapeField& shape,
                            const Pose& pose, const ShapeRegistrationOptions& options) {
  ShapeCurvature out{.centre_ct_mm = Eigen::Vector3d::Zero(),
                     .lever_mm = 0,
                     .scale_mm = 0,
                     .curvature = Matrix6d::Zero()};
  out.counted = nearest_share(points, shape, pose, options.keep_fraction);
  const auto n = static_cast<double>(out.counted.size());
  for (const std::size_t i : out.counted) out.centre_ct_mm += (pose * points[i]).mm / n;
  std::vector<Placed> placed;
  std::vector<double> sizes;
  double lever2 = 0;
  for (const std::size_t i : out.counted) {
    const Eigen::Vector3d p = (pose * points[i]).mm;
    lever2 += (p - out.centre_ct_mm).squaredNorm() / n;
    placed.push_back(place(shape, p, out.centre_ct_mm));
    out.places_ct_mm.push_back(p);
    out.offsets_mm.push_back(placed.back().offset);
    sizes.push_back(placed.back().offset.norm());
  }
  out.lever_mm = std::max(std::sqrt(lever2), 1.0);
  out.scale_mm = std::max(kMadToSigma * median(sizes), options.noise_mm);
  for (std::size_t k = 0; k < placed.size(); ++k) {
    const Placed& one = placed[k];
    const double weight = std::min(1.0, kHuberSigmas * out.scale_mm / std::max(sizes[k], 1e-12));
    out.gradients.push_back(weight * one.by_twist.transpose() * one.offset);
    out.curvature += one.by_twist.transpose() * one.by_twist / n;
  }
  return out;
}

ShapeSolution descend(const ReferencePoints& points, const ShapeField& shape, const Pose& start,
                      const ShapeRegistrationOptions& options, int max_rounds) {
  ShapeSolution solution{start, 0, 0, false};
  for (int round = 0; round < max_rounds && !solution.converged; ++round) {
    const ShapeCurvature at = curvature_at(points, shape, solution.pose, options);
    const double moved_mm = solve_round(points, shape, at, options, solution);
    solution.converged = moved_mm < kStillMm;
  }
  solution.mean_mm = mean_of(points, shape, solution.pose,
                             nearest_share(points, shape, solution.pose, options.keep_fraction));
  return solution;
}

}  // namespace nav::registration
