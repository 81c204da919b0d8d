// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "nav/zeroed_array.hpp"
#include "render/derived/kernels.hpp"
#include "render/derived/run.hpp"

namespace nav::render::derived {

/// Neighbours of a voxel that an edge is stored for: three along the axes, six along the diagonals
/// of the planes of the axes. With their opposites, 18 neighbours.
inline constexpr std::array<std::array<int, 3>, kGraphEdges> kEdgeSteps{{{1, 0, 0},
                                                                         {0, 1, 0},
                                                                         {0, 0, 1},
                                                                         {1, 1, 0},
                                                                         {1, -1, 0},
                                                                         {1, 0, 1},
                                                                         {1, 0, -1},
                                                                         {0, 1, 1},
                                                                         {0, 1, -1}}};

/// A weighted graph on a grid of nodes with a border of nodes without edges, so that no loop asks
/// where the grid ends. Nodes whose value is fixed have no edges either: what they carry is in the
/// leak (and in the right-hand side) of their neighbours. 40 bytes per node.
class GridGraph {
 public:
  explicit GridGraph(const std::array<int, 3>& size);
  /// cells() of a graph of that size: many times its nodes where it is thin.
  static std::size_t cells_of(const std::array<int, 3>& size);

  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }
  /// Length of a vector over the nodes, border included.
  [[nodiscard]] std::size_t cells() const { return cells_; }
  [[nodiscard]] std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k + 1) * static_cast<std::size_t>(size_[1] + 2) +
            static_cast<std::size_t>(j + 1)) *
               static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] std::ptrdiff_t offset(int edge) const {
    return offsets_[static_cast<std::size_t>(edge)];
  }
  [[nodiscard]] GraphRow row(int j, int k) const;
  /// Nodes of a row that kernels run over.
  [[nodiscard]] int row_length() const { return padded(size_[0]); }

  std::array<ZeroedArray<float>, kGraphEdges> weights;
  ZeroedArray<float> leak;

  /// Sum of all edges at a node and its leak.
  [[nodiscard]] double degree(std::size_t node) const;
  /// Galerkin: nodes joined in boxes of factor nodes (1 or 2 along each axis), edges between boxes
  /// summed. Every edge leads to one of the 18 neighbours again.
  [[nodiscard]] GridGraph coarse(const std::array<int, 3>& factor, const RunOptions& run) const;
  /// Mean weight of the edges along each axis, [0] to [2].
  [[nodiscard]] std::array<double, 3> coupling(const RunOptions& run) const;

 private:
  std::array<int, 3> size_;
  int stride_;
  std::size_t cells_;
  std::array<std::ptrdiff_t, kGraphEdges> offsets_{};
};

/// What a solve achieved.
struct SolveReport {
  int iterations = 0;
  int refinements = 0;           ///< Residuals taken anew in double.
  double relative_residual = 0;  ///< |b - A x| / |b| in double before the last refinement.
  double estimated_error = 0;    ///< Root mean square, as SolveOptions::error; NaN: unknown.
  bool converged = false;
};

}  // namespace nav::render::derived
