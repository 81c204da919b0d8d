// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_solver.hpp"

#include <Eigen/Dense>
#include <algorithm>
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
constexpr int kStepAttempts = 6;
constexpr double kStillMm = 1e-3;
constexpr double kNearlyStillMm = 0.03;
constexpr int kExactRounds = 12;
constexpr double kStepStillMm = 1e-4;
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

/// Σ Huber of the offsets of the counted points (half squares near zero), with its normal equations
/// by a twist about a centre when they are asked for.
double robust_sum(const ReferencePoints& points, const ShapeField& shape, const Pose& pose,
                  const std::vector<std::size_t>& counted, double width,
                  const Eigen::Vector3d& centre, Matrix6d* curvature, Vector6d* gradient) {
  double sum = 0;
  for (const std::size_t i : counted) {
    const Placed one = place(shape, (pose * points[i]).mm, centre);
    const double size = one.offset.norm();
    sum += size <= width ? 0.5 * size * size : width * (size - 0.5 * width);
    if (curvature == nullptr) continue;
    const double weight = std::min(1.0, width / std::max(size, 1e-12));
    *curvature += weight * one.by_twist.transpose() * one.by_twist;
    *gradient += weight * one.by_twist.transpose() * one.offset;
  }
  return sum;
}

/// One round of Levenberg–Marquardt in the directions that are seen; returns the points' mean
/// motion, mm.
double solve_round(const ReferencePoints& points, const ShapeField& shape, const ShapeCurvature& at,
                   const ShapeRegistrationOptions& options, ShapeSolution& solution) {
  const Observability seen = observability(at.curvature, at.lever_mm, options.least_strength);
  const Eigen::Index free = 6 - seen.unseen;
  if (free == 0) return 0;
  Eigen::Matrix<double, 6, Eigen::Dynamic> directions(6, free);
  for (Eigen::Index i = 0; i < free; ++i) directions.col(i) = seen.twist(seen.unseen + i);
  const double width = kHuberSigmas * at.scale_mm;
  const Eigen::Vector3d& centre = at.centre_ct_mm;
  Eigen::VectorXd travelled = Eigen::VectorXd::Zero(free);
  double damping = 1e-4;
  for (int step = 0; step < kIterationsPerRound; ++step) {
    Matrix6d curvature = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    const double before =
        robust_sum(points, shape, solution.pose, at.counted, width, centre, &curvature, &gradient);
    const Eigen::MatrixXd normal = directions.transpose() * curvature * directions;
    const Eigen::VectorXd slope = directions.transpose() * gradient;
    bool better = false;
    double moved_mm = 0;
    for (int attempt = 0; attempt < kStepAttempts && !better; ++attempt) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd z = damped.ldlt().solve(-slope);
      const bool usable = z.allFinite() && (travelled + z).norm() <= kMaxShapeTravelMm;
      const Pose pose = usable ? moved(solution.pose, centre, directions * z) : solution.pose;
      better = usable && robust_sum(points, shape, pose, at.counted, width, centre, nullptr,
                                    nullptr) < before;
      damping *= better ? 0.1 : 10;
      if (!better) continue;
      solution.pose = pose;
      travelled += z;
      moved_mm = z.norm();
    }
    ++solution.iterations;
    if (!better || moved_mm < kStepStillMm) break;
  }
  return travelled.norm();
}

}  // namespace

ReferencePoints some_points_of(std::span<const Point<frames::Reference>> points,
                               std::size_t count) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + count - 1) / count);
  ReferencePoints out;
  for (std::size_t i = 0; i < points.size(); i += stride) out.push_back(points[i]);
  return out;
}

double points_apart_mm(const ReferencePoints& points, const Pose& a, const Pose& b) {
  double sum = 0;
  for (const auto& p : points) sum += ((a * p).mm - (b * p).mm).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(points.size(), 1)));
}

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
    // Late rounds may exchange points at the edge of the trimmed share for ever.
    solution.converged = moved_mm < (round < kExactRounds ? kStillMm : kNearlyStillMm);
  }
  solution.mean_mm = mean_of(points, shape, solution.pose,
                             nearest_share(points, shape, solution.pose, options.keep_fraction));
  return solution;
}

}  // namespace nav::registration
