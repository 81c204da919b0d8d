// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/grid_graph.hpp"

#include <algorithm>
#include <cmath>

#include "nav/index.hpp"

namespace nav::render::features {

GridGraph::GridGraph(const std::array<int, 3>& size) : GraphLayout(size), leak(*this) {
  for (auto& edges : kept_) edges = ZeroedArray<float>(cells());
}

GridGraph::GridGraph(const std::array<int, 3>& size, EdgeRule rule)
    : GraphLayout(size), leak(*this), rule_(std::move(rule)) {
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    penalties_[e].assign(as_size(row_length()), rule_->penalties[e]);
  }
}

void GridGraph::weigh(int edge, std::size_t from, std::size_t to, float* out, int count) const {
  kernels().edge_weights(&rule_->values[from], &rule_->values[to], penalties_[as_size(edge)].data(),
                         rule_->constants, out, count);
}

void GridGraph::edges(int edge, int j, int k, float* out) const {
  const std::size_t first = at(0, j, k);
  if (rule_) {
    weigh(edge, first, first + static_cast<std::size_t>(offset(edge)), out, row_length());
  } else {
    std::copy_n(&kept_[as_size(edge)][first], row_length(), out);
  }
}

float GridGraph::weight(int edge, std::size_t node) const {
  if (!rule_) return kept_[as_size(edge)][node];
  float lanes[kLanes];
  weigh(edge, node, node + static_cast<std::size_t>(offset(edge)), lanes, kLanes);
  return lanes[0];
}

void GridGraph::isolate(std::size_t node) {
  if (rule_) {
    rule_->values[node] = NAN;
    return;
  }
  for (int e = 0; e < kGraphEdges; ++e) {
    kept_[as_size(e)][node] = 0;
    kept_[as_size(e)][node - static_cast<std::size_t>(offset(e))] = 0;
  }
}

GraphRow GridGraph::row(int j, int k, Scratch& scratch) const {
  GraphRow row{};
  const std::size_t first = at(0, j, k);
  for (int e = 0; e < kGraphEdges; ++e) {
    const std::size_t n = as_size(e);
    const std::size_t earlier = first - static_cast<std::size_t>(offset(e));
    row.offsets[n] = offset(e);
    if (rule_) {
      scratch.after[n].resize(as_size(row_length()));
      scratch.before[n].resize(as_size(row_length()));
      edges(e, j, k, scratch.after[n].data());
      weigh(e, earlier, first, scratch.before[n].data(), row_length());
      row.after[n] = scratch.after[n].data();
      row.before[n] = scratch.before[n].data();
    } else {
      row.after[n] = &kept_[n][first];
      row.before[n] = &kept_[n][earlier];
    }
  }
  row.leak = leak.row(j, k);
  return row;
}

}  // namespace nav::render::features
