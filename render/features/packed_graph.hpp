// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "render/features/grid_graph.hpp"

namespace nav::render::features {

/// A weight's upper 16 bits, rounded to the nearest: the range of float, relative error 2^-8.
inline std::uint16_t packed_weight(float weight) {
  const auto bits = std::bit_cast<std::uint32_t>(weight);
  return static_cast<std::uint16_t>((bits + 0x7fffU + ((bits >> 16) & 1U)) >> 16);
}
inline float unpacked_weight(std::uint16_t packed) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(packed) << 16);
}

/// A GridGraph with weights of 16 bits, on the same layout: 18 bytes per node. Its quadratic form
/// is the graph's within 2^-8, so that a solve with it takes the error to about 0.004 of what it
/// was; residuals in full precision and another solve do the rest.
class PackedGraph : public GraphLayout {
 public:
  PackedGraph(const GridGraph& graph, const RunOptions& run);
  /// Galerkin: nodes joined in boxes of factor nodes (1 or 2 along each axis), edges between boxes
  /// summed, and rounded. Every edge leads to one of the 18 neighbours again.
  [[nodiscard]] PackedGraph coarse(const std::array<int, 3>& factor, const RunOptions& run) const;

  [[nodiscard]] PackedRow row(int j, int k) const;
  /// Edges, [0, kGraphEdges), from node on; those of [0, 2] lead along the axes.
  [[nodiscard]] const std::uint16_t* edges(int edge, std::size_t node) const {
    return weights_[static_cast<std::size_t>(edge)].data() + node;
  }
  /// Edges to fixed nodes.
  [[nodiscard]] const FewRows& leak() const { return leak_; }
  /// Sums of all edges at the nodes of a row and their leaks; row_length() values.
  void degrees(int j, int k, float* out) const;
  /// Mean weight of the edges along each axis, [0] to [2].
  [[nodiscard]] std::array<double, 3> coupling(const RunOptions& run) const;

 private:
  PackedGraph(const std::array<int, 3>& size, FewRows leak);
  std::array<ZeroedArray<std::uint16_t>, kGraphEdges> weights_;
  FewRows leak_;
};

}  // namespace nav::render::features
