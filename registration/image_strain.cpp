// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_strain.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>

#include "registration/cost_solver.hpp"

namespace nav::registration {
namespace {

constexpr double kMaxStrain = 0.1;
constexpr Eigen::Index kPose = 6, kStrains = 6, kSize = kPose + kStrains;

using Parameters = Eigen::VectorXd;

/// Converts parameters, in mm at 60 mm, to a strain.
ImageScale strain_of(const Eigen::VectorXd& m, const Point<frames::Reference>& centroid) {
  ImageScale strain;
  strain.centre_mm = centroid.mm;
  const Eigen::VectorXd e = m / kRotationScaleMm;
  strain.strain << e[0], e[3], e[4], e[3], e[1], e[5], e[4], e[5], e[2];
  return strain;
}

/// Derivative of a patch's centre by the strains, Reference, mm per mm.
Eigen::Matrix3Xd motion_of(const Patch& patch, const Point<frames::Reference>& centroid) {
  const Eigen::Vector3d r = (patch.centre_mm - centroid.mm) / kRotationScaleMm;
  Eigen::Matrix3Xd motion(3, kStrains);
  motion << r.x(), 0, 0, r.y(), r.z(), 0,  //
      0, r.y(), 0, r.x(), 0, r.z(),        //
      0, 0, r.z(), 0, r.x(), r.y();
  return motion;
}

/// E with the derivatives of E/2 by all parameters.
struct Terms {
  double cost = 0;
  int non_finite = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

/// Residuals as in pose_solver.cpp, with more parameters: fill_residuals().
class StrainCost final : public ceres::CostFunction {
 public:
  StrainCost(const SimilarityCost& cost, const Pose& start,
             const Point<frames::Reference>& centroid, int& non_finite)
      : cost_(cost),
        start_(start),
        centroid_(centroid),
        centre_((start * centroid).mm),
        non_finite_(non_finite) {
    set_num_residuals(static_cast<int>(kSize) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(kSize));
  }

  static Vector6d twist_of(const Parameters& delta) {
    Vector6d twist = delta.head<kPose>();
    twist.head<3>() /= kRotationScaleMm;
    return twist;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Parameters delta = Eigen::Map<const Parameters>(parameters[0], kSize);
    const Eigen::VectorXd m = delta.tail(kStrains);
    if (!delta.allFinite() || delta.head<kPose>().norm() > kMaxTravelMm ||
        m.cwiseAbs().maxCoeff() > kMaxStrain * kRotationScaleMm) {
      return false;
    }
    const bool slopes = jacobians != nullptr && jacobians[0] != nullptr;
    const Terms terms = terms_at(delta, strain_of(m, centroid_), slopes);
    non_finite_ = std::max(non_finite_, terms.non_finite);
    Eigen::Map<Eigen::VectorXd> r(residuals, kSize + 1);
    r.setZero();
    r[kSize] = std::sqrt(terms.cost);
    if (!slopes) return std::isfinite(terms.cost);
    if (!std::isfinite(terms.cost) || !terms.hessian.allFinite()) return false;
    fill(terms, r, jacobians[0]);
    return true;
  }

 private:
  [[nodiscard]] Terms terms_at(const Parameters& delta, const ImageScale& stretch,
                               bool slopes) const {
    const Vector6d twist = twist_of(delta);
    const Pose pose = moved(start_, centre_, twist);
    const PatchSet patches = strained(cost_.patches(), stretch);
    if (!slopes) {
      const CostTerms plain = cost_.on(patches).cost(pose);
      return {plain.cost, plain.non_finite, {}, {}};
    }
    const CtChannels& ct = cost_.ct();
    const GridPose at = grid_pose(ct, pose);
    const Eigen::Vector3d centre = ct.grid_of(centre_ + twist.tail<3>());
    Matrix6d chain = Matrix6d::Identity();
    chain.topLeftCorner<3, 3>() = left_jacobian(twist.head<3>()) / kRotationScaleMm;
    const Matrix6d common = grid_from_ct(ct) * chain;
    Terms sum{0, 0, Eigen::VectorXd::Zero(kSize), Eigen::MatrixXd::Zero(kSize, kSize)};
    for (std::size_t i = 0; i < patches.patches.size(); ++i) {
      const PlacedPatch placed = place(patches, i, at);
      const PatchTerms one = cost_.patch(placed);
      const double w = patches.patches[i].weight;
      if (std::isnan(one.s)) {
        sum.cost += w;
        ++sum.non_finite;
        continue;
      }
      Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(6, kSize);
      by_parameters.leftCols<kPose>() = patch_from_common(placed.centre - centre) * common;
      by_parameters.bottomRightCorner(3, kStrains) =
          at.rotation * motion_of(cost_.patches().patches[i], centroid_);
      sum.cost += w * one.s;
      sum.gradient += w * by_parameters.transpose() * one.gradient;
      sum.hessian += w * by_parameters.transpose() * one.hessian * by_parameters;
    }
    return sum;
  }

  void fill(const Terms& terms, Eigen::Map<Eigen::VectorXd> r, double* jacobian_data) const {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobian_data, kSize + 1, kSize);
    fill_residuals(terms.cost, terms.gradient, terms.hessian, r, jacobian);
  }

  const SimilarityCost& cost_;
  Pose start_;
  Point<frames::Reference> centroid_;
  Eigen::Vector3d centre_;
  int& non_finite_;
};

}  // namespace

PatchSet strained(const PatchSet& patches, const ImageScale& strain) {
  PatchSet out = patches;
  for (Patch& patch : out.patches) {
    patch.centre_mm += strain.strain * (patch.centre_mm - strain.centre_mm);
  }
  return out;
}

StrainSolution solve_strain(const SimilarityCost& cost, const Pose& start,
                            const Point<frames::Reference>& centroid, const SolveLimits& limits,
                            const std::function<bool()>& keep_going) {
  NAV_CHECK(cost.has_patch_terms());
  int non_finite = 0;
  Parameters delta(kSize);
  // Ceres takes ownership.
  auto* residuals = new StrainCost(cost, start, centroid, non_finite);
  const CostSolution found = minimise(residuals, delta, limits, keep_going);
  return {solution_at(moved(start, (start * centroid).mm, StrainCost::twist_of(delta)), found,
                      non_finite),
          strain_of(delta.tail(kStrains), centroid)};
}

}  // namespace nav::registration
