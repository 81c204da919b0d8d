// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "registration/shape/deformable_registration.hpp"

/// Fits of a displacement field to a subset of the ultrasound images. Private to registration/.
namespace nav::registration {

/// A patch at its rigid position; a displacement moves it as a whole.
struct RestingPatch {
  Eigen::Vector3d centre_ct;
  Eigen::Vector3d step_a, step_b, beam;  ///< Grid.
  double weight;                         ///< The weights sum to 1.
  int frame;
  std::size_t index;  ///< Index in the set.
};

/// LC² of patches under a displacement. Keeps references to its arguments. Thread-safe to read.
class DeformedCost {
 public:
  DeformedCost(const CtChannels& ct, const PatchSet& set, const Pose& pose,
               const DeformableOptions& options);
  [[nodiscard]] const std::vector<RestingPatch>& patches() const { return patches_; }
  /// s of a patch, [0, 1]; NaN if a sample is not finite.
  [[nodiscard]] double cost(const RestingPatch& p, const Eigen::Vector3d& displacement) const;

  struct Terms {
    double s;
    Eigen::Vector3d gradient;  ///< Gradient of s/2 by the displacement, Ct, mm.
    Eigen::Matrix3d hessian;   ///< Gauss–Newton.
  };
  [[nodiscard]] Terms terms(const RestingPatch& p, const Eigen::Vector3d& displacement) const;

 private:
  [[nodiscard]] PlacedPatch placed(const RestingPatch& p,
                                   const Eigen::Vector3d& displacement) const;

  const CtChannels& ct_;
  const PatchSet& set_;
  double ridge_;
  std::vector<RestingPatch> patches_;
};

/// A field with the iterations that found it.
struct FieldFit {
  SplineField field;
  int iterations;
  bool finite;  ///< False: a cost was not finite.
};

/// Minimises the mean cost of the patches of the chosen images + bending energy, starting from a
/// field. It uses Levenberg–Marquardt, each step by conjugate gradients on the normal equations
/// without forming their matrix. frames[f]: true if image f is used.
FieldFit fit_field(const DeformedCost& cost, const std::vector<bool>& frames,
                   const SplineField& start, const DeformableOptions& options);

}  // namespace nav::registration
