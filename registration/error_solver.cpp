// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/error_solver.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/cost_solver.hpp"
#include "registration/secant_curvature.hpp"

namespace nav::registration {
namespace {

constexpr Eigen::Index kPoseParameters = 6;
constexpr int kAll = 6 + kErrorParameters;
// Steps along the path of the probe.
constexpr double kPathStepS = 0.02;
// Values beyond these have another cause.
constexpr double kMostDelayS = 1, kMostScale = 0.12, kMostTurnRad = 0.3, kMostShiftMm = 20;
constexpr double kMostPressedMm = 20;
constexpr double kMostPriorSigmas = 4;
constexpr double kClusterMm = 20;
// One unit of a parameter moves the patches by about a millimetre.
constexpr double kDelayUnitS = 0.03;

using AllVector = Eigen::Matrix<double, kAll, 1>;
using AllMatrix = Eigen::Matrix<double, kAll, kAll>;
using ByErrors = Eigen::Matrix<double, 6, kErrorParameters>;

ErrorVector units() {
  ErrorVector out;
  constexpr double kUnit = 1 / kRotationScaleMm;
  out << kDelayUnitS, kUnit, kUnit, 1, kUnit, kUnit, kUnit, 1, 1, 1;
  return out;
}

bool plausible(const ImageErrors& errors) {
  const ErrorVector v = errors.vector();
  return v.allFinite() && std::abs(errors.delay_s) <= kMostDelayS &&
         v.segment<2>(1).cwiseAbs().maxCoeff() <= kMostScale &&
         std::abs(errors.pressed_mm) <= kMostPressedMm && errors.turn_rad.norm() <= kMostTurnRad &&
         errors.shift_mm.norm() <= kMostShiftMm;
}

/// Rotation and translation per second at a moment, Reference; before the first and after the last
/// image those of these images.
std::pair<Eigen::Vector3d, Eigen::Vector3d> speed_at(ProbePath path, double time_s) {
  const auto after =
      std::lower_bound(path.begin(), path.end(), time_s,
                       [](const ImageMotion& motion, double time) { return motion.time_s < time; });
  if (after == path.begin()) return {after->turn_rad_s, after->velocity_mm_s};
  const ImageMotion& before = *std::prev(after);
  if (after == path.end()) return {before.turn_rad_s, before.velocity_mm_s};
  const double share = (time_s - before.time_s) / (after->time_s - before.time_s);
  return {before.turn_rad_s + share * (after->turn_rad_s - before.turn_rad_s),
          before.velocity_mm_s + share * (after->velocity_mm_s - before.velocity_mm_s)};
}

/// How the errors move one image.
struct MovedImage {
  Eigen::Vector3d middle_mm, axis_across;  // Before.
  Eigen::Matrix3d axes;
  Eigen::Matrix3d by_calibration = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();  // Reference, before the delay.
  Eigen::Matrix3d by_delay = Eigen::Matrix3d::Identity();
  Eigen::Vector3d moved_middle_mm;
  Eigen::Vector3d turn_rad_s, velocity_mm_s;  // At the moment of the delay.

  MovedImage(const ImageMotion& motion, const ImageErrors& errors, ProbePath path)
      : middle_mm(motion.middle_mm),
        axis_across(motion.axes.col(0)),
        axes(motion.axes),
        moved_middle_mm(motion.middle_mm),
        turn_rad_s(motion.turn_rad_s),
        velocity_mm_s(motion.velocity_mm_s) {
    by_calibration = exp_rotation(axes * errors.turn_rad).toRotationMatrix();
    shift_mm = axes * errors.shift_mm;
    if (errors.delay_s == 0) return;
    const int steps =
        std::max(1, static_cast<int>(std::lround(std::abs(errors.delay_s) / kPathStepS)));
    const double step_s = errors.delay_s / steps;
    Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
    for (int i = 0; i < steps; ++i) {
      const auto [turn, velocity] = speed_at(path, motion.time_s + (i + 0.5) * step_s);
      turned = exp_rotation(step_s * turn) * turned;
      moved_middle_mm += step_s * velocity;
    }
    by_delay = turned.normalized().toRotationMatrix();
    std::tie(turn_rad_s, velocity_mm_s) = speed_at(path, motion.time_s + errors.delay_s);
  }

  /// Offset of a scaled patch from the middle of its image.
  [[nodiscard]] Eigen::Vector3d scaled(const Patch& patch, const ImageErrors& errors) const {
    const Eigen::Vector3d d = patch.centre_mm - middle_mm;
    const double deeper = (errors.depth_scale - 1) * patch.depth_mm -
                          errors.pressed_mm * pressed_share(patch.depth_mm);
    return d + deeper * patch.beam + (errors.width_scale - 1) * axis_across.dot(d) * axis_across;
  }
  [[nodiscard]] Eigen::Matrix3d rotation() const { return by_delay * by_calibration; }
  /// Offset of a corrected patch from the moved middle.
  [[nodiscard]] Eigen::Vector3d offset(const Patch& patch, const ImageErrors& errors) const {
    return by_delay * (by_calibration * scaled(patch, errors) + shift_mm);
  }

  [[nodiscard]] ByErrors twists(const Patch& patch, const ImageErrors& errors) const {
    ByErrors out = ByErrors::Zero();
    const Eigen::Vector3d from_middle = offset(patch, errors);
    out.col(0) << turn_rad_s, velocity_mm_s + turn_rad_s.cross(from_middle);
    const Eigen::Matrix3d turned = rotation();
    const double across_mm = axis_across.dot(patch.centre_mm - middle_mm);
    out.col(1).tail<3>() = turned * (patch.depth_mm * patch.beam);
    out.col(2).tail<3>() = turned * (across_mm * axis_across);
    out.col(3).tail<3>() = turned * (-pressed_share(patch.depth_mm) * patch.beam);
    const Eigen::Matrix3d own = by_delay * axes;
    const Eigen::Vector3d turned_offset = from_middle - by_delay * shift_mm;
    out.block<3, 3>(0, 4) = own * left_jacobian(errors.turn_rad);
    out.block<3, 3>(3, 4) = -cross_matrix(turned_offset) * out.block<3, 3>(0, 4);
    out.block<3, 3>(3, 7) = own;
    return out;
  }
};

/// The moved images by their index in the sweep: those with patches.
std::map<int, MovedImage> moved_images(const PatchSet& patches, const ImageErrors& errors,
                                       std::span<const ImageMotion> motions, ProbePath path) {
  std::map<int, MovedImage> images;
  for (const Patch& patch : patches.patches) {
    NAV_CHECK(as_size(patch.frame) < motions.size(), patch.frame);
    if (images.contains(patch.frame)) continue;
    images.emplace(patch.frame, MovedImage(motions[as_size(patch.frame)], errors, path));
  }
  return images;
}

// Gauss–Newton's curvature of the patches over the true one: two to five.
constexpr double kStiffness = 3;

/// Scatter of the patches' gradients over their curvature, by the pose: 1 if E/2 were the negative
/// logarithm of a probability.
double temperature(const PatchSet& patches, const CostTerms& terms) {
  std::map<std::array<int, 3>, Vector6d> clusters;
  const Eigen::Vector3d first = patches.patches.front().centre_mm;
  Vector6d scale = Vector6d::Ones();
  scale.head<3>() /= kRotationScaleMm;
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    const Eigen::Array3d cell =
        ((patches.patches[i].centre_mm - first) / kClusterMm).array().floor();
    const auto [at, fresh] = clusters.try_emplace(
        {static_cast<int>(cell[0]), static_cast<int>(cell[1]), static_cast<int>(cell[2])},
        Vector6d::Zero());
    at->second += scale.cwiseProduct(terms.patch_gradients[i]);
  }
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [cell, gradient] : clusters) scatter += gradient * gradient.transpose();
  const Matrix6d hessian = scale.asDiagonal() * terms.hessian * scale.asDiagonal();
  const Eigen::LDLT<Matrix6d> solver(hessian);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return 0;
  const double trace = kStiffness * solver.solve(scatter).trace() / 6;
  return std::isfinite(trace) ? std::max(trace, 0.0) : 0;
}

/// Pose and errors for parameters [60 ω | t | errors in units()] about a start.
struct Unknowns {
  Pose start;
  Eigen::Vector3d centre_ct_mm;
  ErrorVector first;      ///< Errors at the start.
  ErrorVector estimated;  ///< 1 for an error that is estimated, else 0.

  static Vector6d twist_of(const AllVector& delta) {
    Vector6d twist = delta.head<kPoseParameters>();
    twist.head<3>() /= kRotationScaleMm;
    return twist;
  }
  [[nodiscard]] ErrorVector scale() const { return estimated.cwiseProduct(units()); }
  [[nodiscard]] Pose pose(const AllVector& delta) const {
    return moved(start, centre_ct_mm, twist_of(delta));
  }
  [[nodiscard]] ImageErrors errors(const AllVector& delta) const {
    return ImageErrors::of(first + scale().cwiseProduct(delta.tail<kErrorParameters>()));
  }
};

/// Residuals as in pose_solver.cpp, with the errors as further parameters and their prior.
class ErrorCost final : public ceres::CostFunction {
 public:
  ErrorCost(const SimilarityCost& cost, const Unknowns& unknowns, const ErrorSigmas& sigmas,
            std::span<const ImageMotion> motions, ProbePath path, int& non_finite)
      : cost_(cost), unknowns_(unknowns), motions_(motions), path_(path), non_finite_(non_finite) {
    const PatchSet patches =
        corrected(cost.patches(), ImageErrors::of(unknowns.first), motions, path);
    const double weight =
        temperature(patches, cost.on(patches).terms(unknowns.start, unknowns.centre_ct_mm, true));
    const ErrorVector sigma = sigmas.vector();
    most_ = kMostPriorSigmas * sigma;
    precision_ = (sigma.array() > 0).select(weight / sigma.array().square(), 0.0);
    set_num_residuals(kAll + 1);
    mutable_parameter_block_sizes()->push_back(kAll);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const AllVector delta = Eigen::Map<const AllVector>(parameters[0]);
    if (!delta.allFinite() || delta.head<kPoseParameters>().norm() > kMaxTravelMm) return false;
    const ImageErrors errors = unknowns_.errors(delta);
    if (!plausible(errors) || beyond_prior(errors)) return false;
    const bool slopes = jacobians != nullptr && jacobians[0] != nullptr;
    const PatchSet patches = corrected(cost_.patches(), errors, motions_, path_);
    const SimilarityCost cost = cost_.on(patches);
    const Pose pose = unknowns_.pose(delta);
    Eigen::Map<Eigen::Matrix<double, kAll + 1, 1>> r(residuals);
    r.setZero();
    const ErrorVector values = errors.vector();
    const double prior = values.dot(precision_.cwiseProduct(values));
    if (!slopes) {
      const CostTerms terms = cost.cost(pose);
      non_finite_ = std::max(non_finite_, terms.non_finite);
      r[kAll] = std::sqrt(terms.cost + prior);
      return std::isfinite(terms.cost);
    }
    const Vector6d twist = Unknowns::twist_of(delta);
    const Eigen::Vector3d centre = unknowns_.centre_ct_mm + twist.tail<3>();
    const CostTerms terms = cost.terms(pose, centre, true);
    non_finite_ = std::max(non_finite_, terms.non_finite);
    if (!std::isfinite(terms.cost) || !terms.hessian.allFinite()) return false;
    AllVector gradient = AllVector::Zero();
    AllMatrix hessian = AllMatrix::Zero();
    sum(patches, errors, pose, centre, terms, gradient, hessian);
    AllMatrix chain = AllMatrix::Identity();
    chain.topLeftCorner<3, 3>() = left_jacobian(twist.head<3>()) / kRotationScaleMm;
    chain.bottomRightCorner<kErrorParameters, kErrorParameters>() = unknowns_.scale().asDiagonal();
    gradient.tail<kErrorParameters>() += precision_.cwiseProduct(values);
    hessian.bottomRightCorner<kErrorParameters, kErrorParameters>() +=
        Eigen::Matrix<double, kErrorParameters, kErrorParameters>(precision_.asDiagonal());
    const Eigen::VectorXd chained_gradient = chain.transpose() * gradient;
    Eigen::MatrixXd stiff = chain.transpose() * hessian * chain;
    // Errors that are not estimated stay where they are.
    stiff.diagonal().tail<kErrorParameters>() += ErrorVector::Ones() - unknowns_.estimated;
    const Eigen::MatrixXd chained_hessian = curvature_.corrected(delta, chained_gradient, stiff);
    Eigen::Map<Eigen::Matrix<double, kAll + 1, kAll, Eigen::RowMajor>> jacobian(jacobians[0]);
    fill_residuals(terms.cost + prior, chained_gradient, chained_hessian, r, jacobian);
    return true;
  }

 private:
  /// True if an error is larger than what is known of the system allows. Where the sweep does not
  /// show an error, its prior alone may be too weak to hold it.
  [[nodiscard]] bool beyond_prior(const ImageErrors& errors) const {
    const ErrorVector change = (errors.vector() - unknowns_.first).cwiseAbs();
    return (most_.array() > 0 && errors.vector().cwiseAbs().array() > most_.array() &&
            change.array() > 0)
        .any();
  }

  /// Gradient and Hessian of E/2 by the twist of the pose and the errors.
  void sum(const PatchSet& patches, const ImageErrors& errors, const Pose& pose,
           const Eigen::Vector3d& centre, const CostTerms& terms, AllVector& gradient,
           AllMatrix& hessian) const {
    gradient.head<kPoseParameters>() = terms.gradient;
    hessian.topLeftCorner<kPoseParameters, kPoseParameters>() = terms.hessian;
    const auto twists = twists_by_errors(cost_.patches(), errors, motions_, path_);
    const Eigen::Matrix3d turn = pose.rotation().toRotationMatrix();
    for (std::size_t i = 0; i < twists.size(); ++i) {
      const Eigen::Vector3d r =
          (pose * Point<frames::Reference>{patches.patches[i].centre_mm}).mm - centre;
      ByErrors by;
      by.topRows<3>() = turn * twists[i].topRows<3>();
      by.bottomRows<3>() = turn * twists[i].bottomRows<3>() + cross_matrix(r) * by.topRows<3>();
      const ByErrors curved = terms.patch_hessians[i] * by;
      gradient.tail<kErrorParameters>() += by.transpose() * terms.patch_gradients[i];
      hessian.topRightCorner<kPoseParameters, kErrorParameters>() += curved;
      hessian.bottomRightCorner<kErrorParameters, kErrorParameters>() += by.transpose() * curved;
    }
    hessian.bottomLeftCorner<kErrorParameters, kPoseParameters>() =
        hessian.topRightCorner<kPoseParameters, kErrorParameters>().transpose();
  }

  const SimilarityCost& cost_;
  Unknowns unknowns_;
  ErrorVector precision_, most_;
  // Ceres asks for Jacobians on one thread, once for each accepted step.
  mutable SecantCurvature<Eigen::Dynamic> curvature_;
  std::span<const ImageMotion> motions_;
  ProbePath path_;
  int& non_finite_;
};

}  // namespace

PatchSet corrected(const PatchSet& patches, const ImageErrors& errors,
                   std::span<const ImageMotion> motions, ProbePath path) {
  PatchSet out = patches;
  if (errors.none()) return out;
  const auto images = moved_images(patches, errors, motions, path);
  for (Patch& patch : out.patches) {
    const MovedImage& image = images.at(patch.frame);
    const Eigen::Matrix3d turned = image.rotation();
    patch.centre_mm = image.moved_middle_mm + image.offset(patch, errors);
    patch.step_a = turned * patch.step_a;
    patch.step_b = turned * patch.step_b;
    patch.beam = turned * patch.beam;
  }
  return out;
}

std::vector<ByErrors> twists_by_errors(const PatchSet& patches, const ImageErrors& errors,
                                       std::span<const ImageMotion> motions, ProbePath path) {
  const auto images = moved_images(patches, errors, motions, path);
  std::vector<ByErrors> out;
  out.reserve(patches.patches.size());
  for (const Patch& patch : patches.patches) {
    out.push_back(images.at(patch.frame).twists(patch, errors));
  }
  return out;
}

ErrorSolution solve_errors(const SimilarityCost& cost, const Pose& start, const ImageErrors& errors,
                           const Point<frames::Reference>& centroid, const ErrorSigmas& sigmas,
                           std::span<const ImageMotion> motions, ProbePath path,
                           const SolveLimits& limits, const std::function<bool()>& keep_going) {
  NAV_CHECK(cost.has_patch_terms());
  int non_finite = 0;
  const ErrorVector sigma = sigmas.vector();
  const Unknowns unknowns{.start = start,
                          .centre_ct_mm = (start * centroid).mm,
                          .first = errors.vector(),
                          .estimated = (sigma.array() > 0).cast<double>()};
  Eigen::VectorXd delta(kAll);
  // Ceres takes ownership.
  auto* residuals = new ErrorCost(cost, unknowns, sigmas, motions, path, non_finite);
  const CostSolution found = minimise(residuals, delta, limits, keep_going);
  const AllVector all = delta;
  return {solution_at(unknowns.pose(all), found, non_finite), unknowns.errors(all)};
}

}  // namespace nav::registration
