// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/features/multigrid.hpp"
#include "render/features/scan_lines.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// Least gamma with a known error. Below it SolveReport::estimated_error is NaN.
inline constexpr double kKnownErrorGamma = 1e-3;

/// Confidence by random walks (Karamalis et al. 2012): the probability that a walk from a voxel
/// reaches the transducer before the far end of the scan lines.
///
/// The nodes are the known voxels. Edges join 18 neighbours: those along the axes and along the
/// diagonals of the planes of the axes; in the plane of the scan lines these are the paper's eight.
/// Let g be the intensities normalised to [0, 1] over the known voxels, l the depth normalised to
/// [0, 1], c = g (1 - exp(-alpha l)), and D the largest |c_i - c_j| of all edges. The weight of an
/// edge is
///   exp(-beta (|c_i - c_j| / D + gamma a) / (1 + gamma)) + 1e-5,
/// where a is the distance that the edge leads aside of the scan line, in units of the smallest
/// spacing: 0 along the line, 1 across it and diagonally. The floor keeps every voxel connected.
///
/// This is the definition in the authors' program. The paper prints c = g exp(-alpha l), no D, no
/// division by 1 + gamma, and sqrt(2) gamma diagonally. That map falls to 0 within the first
/// millimetres of any tissue whose brightness varies (ADR 52).
///
/// The first known voxel of a scan line is fixed at 1, the last one at 0. Voxels at holes in
/// between are not fixed. A line of one voxel counts as at the transducer.
struct ConfidenceOptions {
  double alpha = 2;     ///< Attenuation, [0, 20].
  double beta = 90;     ///< Steepness, [0, 1000].
  double gamma = 0.05;  ///< Penalty across scan lines, [0, 1]; see kKnownErrorGamma.
  SolveOptions solve;
};
Result<void> validate(const ConfidenceOptions& options);

struct Confidence {
  FeatureVolume volume;  ///< [0, 1]; NaN at unknown voxels and at voxels that are not connected to
                         ///< a fixed voxel.
  SolveReport report;
};

/// Computes the confidence map. Takes about 80 bytes per voxel, 120 if scan lines differ in
/// direction, and more for volumes with few voxels along an axis. A known voxel without a scan line
/// counts as unknown. Rejects volumes in which no voxel is left then. kNumerical if the solver does
/// not converge within its iterations.
Result<Confidence> confidence(const ScalarVolume& volume, const ScanLines& lines,
                              const ConfidenceOptions& options = {}, const RunOptions& run = {});

/// The linear system of a confidence map.
struct ConfidenceSystem {
  GridGraph graph;
  FewRows b;              ///< Sum of the edges to voxels that are fixed at 1.
  ZeroedArray<double> x;  ///< Start: fixed values, NaN at unknown voxels, and a fall from 1 to 0
                          ///< with depth between.
};
Result<ConfidenceSystem> confidence_system(const ScalarVolume& volume, const ScanLines& lines,
                                           const ConfidenceOptions& options, const RunOptions& run);

namespace definition {
/// Solves the same system directly in double (Eigen's SimplicialLDLT), for small volumes.
Result<std::vector<double>> confidence(const ScalarVolume& volume, const ScanLines& lines,
                                       const ConfidenceOptions& options);
}  // namespace definition

}  // namespace nav::render::features
