// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/zeroed_array.hpp"
#include "render/features/graph_layout.hpp"
#include "render/features/run.hpp"

namespace nav::render::features {

/// A rule that computes edges on demand. Its input takes a ninth of the memory of the edges.
struct EdgeRule {
  ZeroedArray<float> values;  ///< Values of the nodes, border included; NaN: no edges.
  std::array<float, kGraphEdges> penalties{};  ///< Penalty of each of kEdgeSteps.
  EdgeConstants constants{};
};

/// A weighted graph on a grid of nodes, in full precision. Nodes with a fixed value have no edges;
/// their contribution is in the leak (and in the right-hand side) of their neighbours. Edges are
/// stored, 36 bytes per node, or computed by a rule, 4 bytes per node.
class GridGraph : public GraphLayout {
 public:
  /// Makes a graph without edges.
  explicit GridGraph(const std::array<int, 3>& size);
  GridGraph(const std::array<int, 3>& size, EdgeRule rule);

  FewRows leak;  ///< Sum of the edges to fixed nodes.
  /// Stored weights of an edge, [0, kGraphEdges), by the node where it begins. Only for stored
  /// edges.
  ZeroedArray<float>& kept(int edge) { return kept_[static_cast<std::size_t>(edge)]; }

  /// Weights of the edges that begin at the nodes of a row; row_length() values.
  void edges(int edge, int j, int k, float* out) const;
  /// Weight of one edge; 0 if there is none.
  [[nodiscard]] float weight(int edge, std::size_t node) const;
  /// Removes all edges of a node.
  void isolate(std::size_t node);
  /// Buffer for the edges of a row.
  struct Scratch {
    std::array<std::vector<float>, kGraphEdges> after, before;
  };
  /// A row of the matrix. Valid until scratch is used for another row.
  GraphRow row(int j, int k, Scratch& scratch) const;

 private:
  /// Computes the edges between two rows of nodes by the rule.
  void weigh(int edge, std::size_t from, std::size_t to, float* out, int count) const;
  std::array<ZeroedArray<float>, kGraphEdges> kept_;
  std::optional<EdgeRule> rule_;
  std::array<std::vector<float>, kGraphEdges> penalties_;  ///< Penalties of the rule, repeated
                                                           ///< along a row.
};

/// Result of a solve.
struct SolveReport {
  int iterations = 0;
  int refinements = 0;           ///< Number of residuals recomputed in double.
  double relative_residual = 0;  ///< |b - A x| / |b| in double before the last refinement.
  double estimated_error = 0;    ///< Root mean square, see SolveOptions::error; NaN: unknown.
  bool converged = false;
};

}  // namespace nav::render::features
