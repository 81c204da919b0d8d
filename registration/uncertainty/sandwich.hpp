// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "registration/search/costs_around.hpp"
#include "registration/similarity/lc2_cost.hpp"
#include "registration/similarity/sweep_points.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Twist [ω | t], rad and mm, of scaled parameters [60 ω | t] mm: a diagonal.
Matrix6d twist_from_scaled();

/// What one picture adds to the cost about a minimum, of E/2, in scaled parameters.
struct PictureShape {
  int frame;      ///< Index in the sweep.
  double weight;  ///< Of its patches; those of all pictures sum to 1.
  double way_mm;  ///< Its patches from the plane of the picture before, mean; 0 of the first.
  Vector6d gradient;
  Matrix6d hessian;  ///< Gauss–Newton, of all its patches; 0 or positive.
};

/// The cost about a minimum, in scaled parameters [60 ω | t] mm about a centre.
struct LocalShape {
  Point<frames::Ct> centre_ct;
  Matrix6d hessian;  ///< Of E/2, true: symmetric differences of the exact gradient.
  std::vector<Vector6d> patch_gradients;  ///< wᵢ gᵢ of each patch, of E/2.
  std::vector<PictureShape> pictures;     ///< Those with patches, in the order of the sweep.
  /// wᵢ Hᵢ of each patch by a twist [rad | mm], Gauss–Newton; empty of mutual information.
  std::vector<Matrix6d> patch_hessians = {};
};

/// The step of local_shape() that a registration takes, as a share of the finest samples' step.
inline constexpr double kCurvatureSteps = 0.5;

/// Gauss–Newton's Hessian is too stiff, as each patch also fits its noise: the true one is taken by
/// symmetric differences over step_mm, of at most 600 patches evenly chosen.
LocalShape local_shape(const Lc2Cost& cost, const Pose& pose, const Point<frames::Ct>& centre_ct,
                       double step_mm);
/// The same by the gradients beside a pose, which are known: of cost and its sweep, whose centre at
/// the pose is the shape's.
LocalShape local_shape(const Lc2Cost& cost, const Point<frames::Ct>& centre_ct,
                       const CostsAround& around);

/// Why a Hessian in scaled parameters determines no pose: not finite, the direction along which it
/// falls, or the one along which it hardly rises; empty where it does.
std::string curvature_fault(const Matrix6d& hessian);

/// Covariance of an image registration, or why there is none.
struct SandwichCovariance {
  PoseUncertainty uncertainty;
  bool valid;
  std::string fault;  ///< One sentence that names the direction; empty when valid.
};

/// Σ = H⁻¹ (n/(n−6) Σ_b g_b g_bᵀ) H⁻¹ at a minimum of the cost. g_b sums the gradients of all
/// patches in one 20 mm cube of the CT: pictures that see the same anatomy err together.
/// bias_floor_mm² is added to the translations and, over 60 mm, to the rotations. (White 1980;
/// Liang and Zeger 1986.)
SandwichCovariance sandwich_covariance(const LocalShape& shape, const PatchSet& patches,
                                       const Pose& pose, double bias_floor_mm);

/// How to halve the pictures of a sweep.
enum class Halves { kOddEven, kFirstSecond };

/// How far apart halves of the pictures put the sweep.
struct Disagreement {
  double rms_mm;      ///< Over the sweep; infinite where it is not known.
  std::string fault;  ///< Why not: what was expected and what was found; empty where it is known.
};

/// Between the poses that two halves of the pictures would move to, each by one Newton step
/// −H⁻¹ g_half from the pose of all. Not known where only one picture has patches, where a half has
/// fewer than kMinPatches, or where H is not positive definite (then the fault is
/// curvature_fault()).
Disagreement disagreement(const LocalShape& shape, const PatchSet& patches,
                          const SweepPoints& sweep, const Pose& pose, Halves halves);

}  // namespace nav::registration
