// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "registration/similarity/ct_channels.hpp"
#include "registration/twist.hpp"

namespace nav::registration {

/// Largest patch side that the kernel takes.
inline constexpr int kMaxPatchSide = 21;

/// A square in-plane patch placed in the CT grid. Sample (a, b), a fastest, lies at centre + (a −
/// h)·step_a + (b − h)·step_b with h = (side − 1)/2.
struct PlacedPatch {
  Eigen::Vector3d centre;          ///< Grid, mm.
  Eigen::Vector3d step_a, step_b;  ///< Grid, mm per sample.
  Eigen::Vector3d beam;            ///< Grid, unit, away from the transducer.
  int side;                        ///< Odd, at most kMaxPatchSide.
  std::span<const float> u;        ///< side² ultrasound samples, mean 0, norm 1.
};

/// Value and derivatives of one patch's term.
struct PatchTerms {
  double s;  ///< 1 − LC² with ridge, [0, 1]; NaN when any sample is not finite.
  /// Gradient of s/2 by a twist [rotation | translation] about the centre, Grid, mm.
  Vector6d gradient;
  Matrix6d hessian;  ///< Gauss–Newton (Kaufman) of s/2, positive semi-definite.
};

/// s = min_c ‖u − A c‖² + n λ² ‖c‖², A = [f, g] centred over the n samples; f is the CT, and g is
/// the magnitude of its derivative along the beam, sqrt((d·G)² + ε²). With S = AᵀA + nλ²I, c =
/// S⁻¹Aᵀu and V = (dA/dtwist) c centred: gradient = −Vᵀ(u − Ac), exact; hessian = VᵀV − VᵀA S⁻¹ AᵀV
/// (Kaufman 1975; Golub and Pereyra 1973). Samples outside the grid take the nearest border value
/// and do not move. Precondition: ridge > 0.
/// intensity_only: A = [f] alone; then s is 1 − NCC² apart from the ridge.
PatchTerms patch_terms(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                       bool intensity_only = false);

/// s and the gradient of patch_terms(), in less time; the Hessian is 0.
PatchTerms patch_gradient(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                          bool intensity_only = false);

/// s of patch_terms() alone, with the same bits.
double patch_cost(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                  bool intensity_only = false);

/// f and its gradient (Grid, per mm; 0 along axes that were clamped) at the samples of a patch, in
/// their order. Returns false if the patch is not finite. Both spans have side² elements; by_point
/// may be empty.
bool patch_intensities(const CtChannels& ct, const PlacedPatch& patch, std::span<float> f,
                       std::span<Eigen::Vector3f> by_point);

}  // namespace nav::registration
