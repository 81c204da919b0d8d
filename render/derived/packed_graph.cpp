// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived/packed_graph.hpp"

#include <algorithm>

#include "render/derived/graph_rows.hpp"

namespace nav::render::derived {

PackedGraph::PackedGraph(const GridGraph& graph, const RunOptions& run)
    : size_(graph.size()),
      first_(graph.at(0, 0, 0)),
      stride_(static_cast<std::size_t>(graph.offset(1))),
      plane_(static_cast<std::size_t>(graph.offset(2))),
      leak_(graph.cells()) {
  for (int edge = 0; edge < kGraphEdges; ++edge) {
    const auto e = static_cast<std::size_t>(edge);
    offsets_[e] = graph.offset(edge);
    weights_[e] = ZeroedArray<std::uint16_t>(graph.cells());
  }
  for_each_row(graph, run, [&](int, int, std::size_t first) {
    const auto count = static_cast<std::size_t>(row_length());
    std::copy_n(&graph.leak[first], count, &leak_[first]);
    for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
      const float* from = &graph.weights[e][first];
      std::transform(from, from + count, &weights_[e][first], packed_weight);
    }
  });
}

PackedRow PackedGraph::row(int j, int k) const {
  PackedRow row{};
  const std::size_t first = at(0, j, k);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    row.weights[e] = weights_[e].data() + first;
    row.offsets[e] = offsets_[e];
  }
  row.leak = leak_.data() + first;
  return row;
}

void PackedGraph::degrees(int j, int k, float* out) const {
  const std::size_t first = at(0, j, k);
  const auto count = static_cast<std::size_t>(row_length());
  std::copy_n(&leak_[first], count, out);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    const std::uint16_t* after = &weights_[e][first];
    const std::uint16_t* before = &weights_[e][first - static_cast<std::size_t>(offsets_[e])];
    for (std::size_t i = 0; i < count; ++i) {
      out[i] += unpacked_weight(after[i]) + unpacked_weight(before[i]);
    }
  }
}

}  // namespace nav::render::derived
