// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/features/multigrid.hpp"
#include "render/features/scan_lines.hpp"
#include "render/features/volume.hpp"

namespace nav::render::features {

/// With less gamma no error is stated (SolveReport::estimated_error is NaN).
inline constexpr double kKnownErrorGamma = 1e-3;

/// Confidence by random walks (Karamalis et al. 2012): the probability that a walk from a voxel
/// reaches the transducer before the far end of the scan lines.
///
/// Nodes are the known voxels, edges join 18 neighbours (along the axes and the diagonals of their
/// planes; in the plane of the scan lines the paper's eight). With intensities g normalised to
/// [0, 1] over the known voxels, l the depth normalised to [0, 1], c = g (1 - exp(-alpha l)) and D
/// the largest |c_i - c_j| of any edge, an edge weighs
///   exp(-beta (|c_i - c_j| / D + gamma a) / (1 + gamma)) + 1e-5,
/// where a is how far it leads aside of the scan line, in units of the smallest spacing: 0 along
/// it, 1 across it and diagonally. The floor keeps every voxel connected.
///
/// That is what the authors' program computes. The paper prints c = g exp(-alpha l), no D, no
/// division by 1 + gamma, and sqrt(2) gamma diagonally: a map that falls to 0 within the first
/// millimetres of any tissue that is not of one brightness (ADR 52).
///
/// Fixed at 1: the first known voxel of a scan line, at 0: the last one (holes in between are
/// neither). A line of one voxel is at the transducer.
struct ConfidenceOptions {
  double alpha = 2;     ///< Attenuation, [0, 20].
  double beta = 90;     ///< Steepness, [0, 1000].
  double gamma = 0.05;  ///< Penalty across scan lines, [0, 1]; see kKnownErrorGamma.
  SolveOptions solve;
};
Result<void> validate(const ConfidenceOptions& options);

struct Confidence {
  FeatureVolume volume;  ///< [0, 1]; NaN at unknown voxels and where no fixed voxel is connected.
  SolveReport report;
};

/// Holds about 80 bytes per voxel, 120 where scan lines differ, more of volumes with few voxels
/// along an axis. A known voxel without a scan line counts as unknown. Refuses volumes where no
/// voxel is left then. kNumerical when it did not converge within its iterations.
Result<Confidence> confidence(const ScalarVolume& volume, const ScanLines& lines,
                              const ConfidenceOptions& options = {}, const RunOptions& run = {});

/// The linear system of a confidence map.
struct ConfidenceSystem {
  GridGraph graph;
  FewRows b;              ///< Sum of the edges to voxels fixed at 1.
  ZeroedArray<double> x;  ///< Start: fixed values, NaN where unknown, depth from 1 to 0 between.
};
Result<ConfidenceSystem> confidence_system(const ScalarVolume& volume, const ScanLines& lines,
                                           const ConfidenceOptions& options, const RunOptions& run);

namespace definition {
/// The same system solved directly in double (Eigen's SimplicialLDLT): for small volumes.
Result<std::vector<double>> confidence(const ScalarVolume& volume, const ScanLines& lines,
                                       const ConfidenceOptions& options);
}  // namespace definition

}  // namespace nav::render::features
