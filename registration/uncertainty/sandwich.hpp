// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "registration/search/costs_around.hpp"
#include "registration/similarity/similarity_cost.hpp"
#include "registration/similarity/sweep_points.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Diagonal matrix that converts scaled parameters [60 ω | t] mm to a twist [ω | t], rad and mm.
Matrix6d twist_from_scaled();

/// Contribution of one ultrasound image to E/2 about a minimum, in scaled parameters.
struct ImageShape {
  int frame;      ///< Index in the sweep.
  double weight;  ///< Weight of its patches; the weights of all images sum to 1.
  /// Mean distance of its patches from the plane of the image before; 0 for the first.
  double way_mm;
  Vector6d gradient;
  Matrix6d hessian;  ///< Gauss–Newton Hessian of all its patches; 0 or positive.
};

/// The cost about a minimum, in scaled parameters [60 ω | t] mm about a centre.
struct LocalShape {
  Point<frames::Ct> centre_ct;
  Matrix6d hessian;  ///< Hessian of E/2, the true one: symmetric differences of the exact gradient.
  std::vector<Vector6d> patch_gradients;  ///< wᵢ gᵢ of each patch, for E/2.
  std::vector<ImageShape> images;         ///< Images with patches, in the order of the sweep.
  /// wᵢ Hᵢ of each patch by a twist [rad | mm], Gauss–Newton; empty for mutual information.
  std::vector<Matrix6d> patch_hessians = {};
};

/// Step of local_shape() in a registration, as a fraction of the finest samples' step.
inline constexpr double kCurvatureSteps = 0.5;

/// Computes the cost about a pose. The Gauss–Newton Hessian is too stiff, because each patch also
/// fits its noise; the true one is computed by symmetric differences over step_mm, of at most 600
/// evenly chosen patches.
LocalShape local_shape(const SimilarityCost& cost, const Pose& pose,
                       const Point<frames::Ct>& centre_ct, double step_mm);
/// local_shape() from known gradients beside a pose. They must have been computed from cost and its
/// sweep; the shape's centre must be that of the sweep at the pose.
LocalShape local_shape(const SimilarityCost& cost, const Point<frames::Ct>& centre_ct,
                       const CostsAround& around);

/// Reason why a Hessian in scaled parameters does not determine a pose: it is not finite, or the
/// cost falls or hardly rises along a direction, which is named. Empty if it does determine one.
std::string curvature_fault(const Matrix6d& hessian);

/// Covariance of an image registration, or the reason why there is none.
struct SandwichCovariance {
  PoseUncertainty uncertainty;
  bool valid;
  std::string fault;  ///< One sentence that names the direction; empty when valid.
};

/// Σ = H⁻¹ (n/(n−6) Σ_b g_b g_bᵀ) H⁻¹ at a minimum of the cost. g_b sums the gradients of all
/// patches in one 20 mm cube of the CT, because images of the same anatomy have common errors.
/// bias_floor_mm² is added to the translations and, over 60 mm, to the rotations. (White 1980;
/// Liang and Zeger 1986.)
SandwichCovariance sandwich_covariance(const LocalShape& shape, const PatchSet& patches,
                                       const Pose& pose, double bias_floor_mm);

/// Ways to divide the ultrasound images of a sweep into halves.
enum class Halves { kOddEven, kFirstSecond };

/// Distance between the poses of two halves of the images.
struct Disagreement {
  double rms_mm;  ///< RMS over the sweep; infinite if it is not known.
  /// Why it is not known: what was expected and what was found; empty if it is known.
  std::string fault;
};

/// Distance between the poses that two halves of the images would move to, each by one Newton step
/// −H⁻¹ g_half from the pose of all. Not known if only one image has patches, if a half has fewer
/// than kMinPatches, or if H is not positive definite (then the fault is curvature_fault()).
Disagreement disagreement(const LocalShape& shape, const PatchSet& patches,
                          const SweepPoints& sweep, const Pose& pose, Halves halves);

}  // namespace nav::registration
