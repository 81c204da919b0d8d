// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav::render::features {

/// Number of values per step of the kernels below. Every row that they read or write has room for a
/// multiple of this number from its start. The values after the last one must be finite.
inline constexpr int kLanes = 8;

inline constexpr int padded(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

/// Folded taps of a symmetric or antisymmetric filter, [0, radius].
struct FoldedTaps {
  const float* smooth;  ///< out = t0 f0 + sum tk (f+k + f-k)
  const float* slope;   ///< out = sum tk (f+k - f-k)
  const float* bend;    ///< Same formula as smooth.
};

/// Constants of Frangi's measure: 1/(2 alpha^2), 1/(2 beta^2), 1/(2 c^2). sign: -1 for bright tubes
/// on dark ground, +1 for dark tubes on bright ground.
struct TubeConstants {
  float plate, blob, structure, sign;
};

/// Rows of the six second derivatives.
struct HessianRows {
  const float *xx, *yy, *zz, *xy, *xz, *yz;
};

/// Moments of windows: sum of weights, mean, sum of weighted squared distances from the mean.
struct MomentRows {
  double *weight, *mean, *spread;
};
struct ConstMomentRows {
  const double *weight, *mean, *spread;
};

/// Number of undirected edges that are stored at each node of a grid graph.
inline constexpr int kGraphEdges = 9;

/// One row of a graph's matrix: after[e] joins node i and node i + offsets[e]; before[e] joins node
/// i and node i - offsets[e].
struct GraphRow {
  const float* after[kGraphEdges];
  const float* before[kGraphEdges];
  std::ptrdiff_t offsets[kGraphEdges];
  const float* leak;  ///< Sum of the edges to nodes whose value is fixed.
};

/// A GraphRow with weights of 16 bits. Weights of one edge are also offsets[e] apart.
struct PackedRow {
  const unsigned short* weights[kGraphEdges];  ///< packed_weight(); see GraphRow::after.
  std::ptrdiff_t offsets[kGraphEdges];
  const float* leak;
};

/// z · z and r · z of two vectors. This type has no functions, because these would be compiled for
/// each instruction set and merged.
struct Products {
  double zz, rz;
};

/// Constants of an edge of the random walk: exp(-beta (|a - b| + penalty)) + floor.
struct EdgeConstants {
  float beta, floor;
};

/// The inner loops, compiled for plain x86-64 (or any other processor) and again with AVX2 and FMA.
/// Thread-safe. The two versions round differently: compare their results with a tolerance.
struct Kernels {
  const char* name;
  /// Applies one to three filters to rows[0 … 2 radius], with rows[radius] in the middle. A null
  /// out is not computed. out[0]: smooth, out[1]: slope, out[2]: bend.
  void (*filter_rows)(const float* const* rows, int radius, const FoldedTaps& taps,
                      float* const out[3], int count);
  /// best = max(best, response) per voxel. Computes eigenvalues only if a tube is possible.
  void (*tube_response)(const HessianRows& rows, const TubeConstants& constants, float* best,
                        int count);
  /// Ascending eigenvalues of symmetric matrices.
  void (*eigenvalues)(const HessianRows& rows, float* low, float* middle, float* high, int count);
  /// Merges the moments of windows, each multiplied by a weight.
  void (*merge_moments)(const ConstMomentRows* windows, const double* weights, int windows_count,
                        const MomentRows& out, int count);
  /// out_i = leak_i x_i + sum over edges w_ij (x_i - x_j).
  void (*laplacian)(const GraphRow& row, const double* x, double* out, int count);
  /// out = A x for a row; returns x · x and x · out.
  Products (*packed_laplacian)(const PackedRow& row, const float* x, float* out, int count);
  /// out = b - A x for a row.
  void (*packed_residual)(const PackedRow& row, const float* b, const float* x, float* out,
                          int count);
  /// v = (v + w before) pivot, and v += pivot w after: one step in the solve of every line.
  void (*line_forward)(const unsigned short* w, const float* pivot, const float* before, float* v,
                       int count);
  void (*line_backward)(const unsigned short* w, const float* pivot, const float* after, float* v,
                        int count);
  /// out = scale (x + damping step) where pivot > 0, 0 elsewhere; returns out · out and out · b.
  Products (*damped_step)(const float* x, const float* step, const float* pivot, const float* b,
                          float damping, float scale, float* out, int count);
  /// a · b in double.
  double (*dot)(const float* a, const float* b, int count);
  /// e += alpha p, r -= alpha ap; returns r · r.
  double (*step)(float alpha, const float* p, const float* ap, float* e, float* r, int count);
  /// scale times the distance that an edge leads aside of the mean direction of its ends.
  /// Directions are unit vectors, three rows each. 0 if the two directions are opposite.
  void (*edge_penalties)(const float* const here[3], const float* const there[3],
                         const float edge[3], float scale, float* out, int count);
  /// Weights of edges; 0 if either end is NaN.
  void (*edge_weights)(const float* here, const float* there, const float* penalty,
                       const EdgeConstants& constants, float* out, int count);
};

/// The fastest version that this processor supports.
const Kernels& kernels();
/// The version that every processor supports.
const Kernels& portable_kernels();

}  // namespace nav::render::features
