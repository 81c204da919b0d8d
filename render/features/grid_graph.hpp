// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/zeroed_array.hpp"
#include "render/features/graph_layout.hpp"
#include "render/features/run.hpp"

namespace nav::render::features {

/// Edges that are computed where they are asked for, since what they follow from takes a ninth of
/// their memory.
struct EdgeRule {
  ZeroedArray<float> values;                   ///< Of the nodes; NaN: no edges, border included.
  std::array<float, kGraphEdges> penalties{};  ///< Of each of kEdgeSteps.
  EdgeConstants constants{};
};

/// A weighted graph on a grid of nodes, in full precision. Nodes whose value is fixed have no
/// edges: what they carry is in the leak (and in the right-hand side) of their neighbours. Edges
/// are kept, 36 bytes per node, or follow from a rule, 4 bytes.
class GridGraph : public GraphLayout {
 public:
  /// Without any edge yet.
  explicit GridGraph(const std::array<int, 3>& size);
  GridGraph(const std::array<int, 3>& size, EdgeRule rule);

  FewRows leak;  ///< Sum of the edges to fixed nodes.
  /// Of a graph that keeps its edges, [0, kGraphEdges), by the node that they begin at.
  ZeroedArray<float>& kept(int edge) { return kept_[static_cast<std::size_t>(edge)]; }

  /// Of the edges that begin at the nodes of a row; row_length() values.
  void edges(int edge, int j, int k, float* out) const;
  /// Of one edge; 0 where there is none.
  [[nodiscard]] float weight(int edge, std::size_t node) const;
  /// Takes all edges of a node away.
  void isolate(std::size_t node);
  /// Room for the edges of a row.
  struct Scratch {
    std::array<std::vector<float>, kGraphEdges> after, before;
  };
  /// Valid while scratch is not used for another row.
  GraphRow row(int j, int k, Scratch& scratch) const;

 private:
  /// Of edges between two rows of nodes, by the rule.
  void weigh(int edge, std::size_t from, std::size_t to, float* out, int count) const;
  std::array<ZeroedArray<float>, kGraphEdges> kept_;
  std::optional<EdgeRule> rule_;
  std::array<std::vector<float>, kGraphEdges> penalties_;  ///< Of the rule, along a row.
};

/// What a solve achieved.
struct SolveReport {
  int iterations = 0;
  int refinements = 0;           ///< Residuals taken anew in double.
  double relative_residual = 0;  ///< |b - A x| / |b| in double before the last refinement.
  double estimated_error = 0;    ///< Root mean square, as SolveOptions::error; NaN: unknown.
  bool converged = false;
};

}  // namespace nav::render::features
