// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_scale.hpp"

#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>

#include "registration/cost_solver.hpp"

namespace nav::registration {
namespace {

constexpr double kMaxStrain = 0.1;
constexpr Eigen::Index kPose = 6;

using Parameters = Eigen::VectorXd;

Eigen::Index count_of(ScaleModel model) { return model == ScaleModel::kSoundSpeed ? 1 : 6; }

/// Converts parameters, in mm at 60 mm, to a depth factor or strain.
ImageScale stretch_of(ScaleModel model, const Eigen::VectorXd& m,
                      const Point<frames::Reference>& centroid) {
  ImageScale stretch;
  stretch.centre_mm = centroid.mm;
  const Eigen::VectorXd e = m / kRotationScaleMm;
  if (model == ScaleModel::kSoundSpeed) {
    stretch.depth_scale = 1 + e[0];
  } else {
    stretch.strain << e[0], e[3], e[4], e[3], e[1], e[5], e[4], e[5], e[2];
  }
  return stretch;
}

/// Derivative of a patch's centre by the parameters, Reference, mm per mm.
Eigen::Matrix3Xd motion_of(ScaleModel model, const Patch& patch,
                           const Point<frames::Reference>& centroid) {
  if (model == ScaleModel::kSoundSpeed) return patch.depth_mm / kRotationScaleMm * patch.beam;
  const Eigen::Vector3d r = (patch.centre_mm - centroid.mm) / kRotationScaleMm;
  Eigen::Matrix3Xd motion(3, 6);
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
class ScaleCost final : public ceres::CostFunction {
 public:
  ScaleCost(const Lc2Cost& cost, const Pose& start, const Point<frames::Reference>& centroid,
            ScaleModel model, int& non_finite)
      : cost_(cost),
        start_(start),
        centroid_(centroid),
        centre_((start * centroid).mm),
        model_(model),
        size_(kPose + count_of(model)),
        non_finite_(non_finite) {
    set_num_residuals(static_cast<int>(size_) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(size_));
  }

  static Vector6d twist_of(const Parameters& delta) {
    Vector6d twist = delta.head<kPose>();
    twist.head<3>() /= kRotationScaleMm;
    return twist;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Parameters delta = Eigen::Map<const Parameters>(parameters[0], size_);
    const Eigen::VectorXd m = delta.tail(size_ - kPose);
    if (!delta.allFinite() || delta.head<kPose>().norm() > kMaxTravelMm ||
        m.cwiseAbs().maxCoeff() > kMaxStrain * kRotationScaleMm) {
      return false;
    }
    const bool slopes = jacobians != nullptr && jacobians[0] != nullptr;
    const Terms terms = terms_at(delta, stretch_of(model_, m, centroid_), slopes);
    non_finite_ = std::max(non_finite_, terms.non_finite);
    Eigen::Map<Eigen::VectorXd> r(residuals, size_ + 1);
    r.setZero();
    r[size_] = std::sqrt(terms.cost);
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
    const PatchSet patches = stretched(cost_.patches(), stretch);
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
    Terms sum{0, 0, Eigen::VectorXd::Zero(size_), Eigen::MatrixXd::Zero(size_, size_)};
    for (std::size_t i = 0; i < patches.patches.size(); ++i) {
      const PlacedPatch placed = place(patches, i, at);
      const PatchTerms one = cost_.patch(placed);
      const double w = patches.patches[i].weight;
      if (std::isnan(one.s)) {
        sum.cost += w;
        ++sum.non_finite;
        continue;
      }
      Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(6, size_);
      by_parameters.leftCols<kPose>() = patch_from_common(placed.centre - centre) * common;
      by_parameters.bottomRightCorner(3, size_ - kPose) =
          at.rotation * motion_of(model_, cost_.patches().patches[i], centroid_);
      sum.cost += w * one.s;
      sum.gradient += w * by_parameters.transpose() * one.gradient;
      sum.hessian += w * by_parameters.transpose() * one.hessian * by_parameters;
    }
    return sum;
  }

  void fill(const Terms& terms, Eigen::Map<Eigen::VectorXd> r, double* jacobian_data) const {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobian_data, size_ + 1, size_);
    fill_residuals(terms.cost, terms.gradient, terms.hessian, r, jacobian);
  }

  const Lc2Cost& cost_;
  Pose start_;
  Point<frames::Reference> centroid_;
  Eigen::Vector3d centre_;
  ScaleModel model_;
  Eigen::Index size_;
  int& non_finite_;
};

}  // namespace

PatchSet stretched(const PatchSet& patches, const ImageScale& stretch) {
  PatchSet out = patches;
  for (Patch& patch : out.patches) {
    patch.centre_mm += (stretch.depth_scale - 1) * patch.depth_mm * patch.beam +
                       stretch.strain * (patch.centre_mm - stretch.centre_mm);
  }
  return out;
}

ScaleSolution solve_scale(const Lc2Cost& cost, const Pose& start,
                          const Point<frames::Reference>& centroid, ScaleModel model,
                          const SolveLimits& limits, const std::function<bool()>& keep_going) {
  NAV_CHECK(model != ScaleModel::kNone);
  NAV_CHECK(cost.similarity() != Similarity::kMutualInformation);
  int non_finite = 0;
  Parameters delta(kPose + count_of(model));
  // Ceres takes ownership.
  auto* residuals = new ScaleCost(cost, start, centroid, model, non_finite);
  const CostSolution found = minimise(residuals, delta, limits, keep_going);
  return {solution_at(moved(start, (start * centroid).mm, ScaleCost::twist_of(delta)), found,
                      non_finite),
          stretch_of(model, delta.tail(delta.size() - kPose), centroid)};
}

}  // namespace nav::registration
