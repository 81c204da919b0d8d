// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/packed_graph.hpp"

#include <algorithm>

#include "nav/index.hpp"
#include "render/features/graph_rows.hpp"

namespace nav::render::features {
namespace {

/// An edge from a node to a different box.
struct Leaving {
  int edge;
  bool forward;      ///< True: the edge is stored at this node. False: at its other end.
  std::size_t slot;  ///< Index into kEdgeSteps, for the boxes.
};

/// Edges that lead out of the box, for a node at a position in its box.
std::vector<Leaving> leaving_edges(const std::array<int, 3>& place,
                                   const std::array<int, 3>& factor) {
  std::vector<Leaving> found;
  for (int e = 0; e < kGraphEdges; ++e) {
    for (const int sign : {1, -1}) {
      std::array<int, 3> step{};
      for (std::size_t a = 0; a < 3; ++a) {
        // The sum lies within [-1, 2]. Adding factor makes the division round down below 0 too.
        step[a] = (place[a] + sign * kEdgeSteps[as_size(e)][a] + factor[a]) / factor[a] - 1;
      }
      const auto slot = std::find(kEdgeSteps.begin(), kEdgeSteps.end(), step) - kEdgeSteps.begin();
      if (slot == kGraphEdges) continue;  // Inside the box, or added by the other box.
      found.push_back({e, sign == 1, static_cast<std::size_t>(slot)});
    }
  }
  return found;
}

}  // namespace

PackedGraph::PackedGraph(const std::array<int, 3>& size, FewRows leak)
    : GraphLayout(size), leak_(std::move(leak)) {
  for (auto& edges : weights_) edges = ZeroedArray<std::uint16_t>(cells());
}

PackedGraph::PackedGraph(const GridGraph& graph, const RunOptions& run)
    : PackedGraph(graph.size(), graph.leak) {
  for_each_plane(size()[2], run, [&](int k) {
    std::vector<float> exact(as_size(row_length()));
    for (int j = 0; j < size()[1]; ++j) {
      for (int e = 0; e < kGraphEdges; ++e) {
        graph.edges(e, j, k, exact.data());
        std::ranges::transform(exact, &weights_[as_size(e)][at(0, j, k)], packed_weight);
      }
    }
  });
}

PackedRow PackedGraph::row(int j, int k) const {
  PackedRow row{};
  const std::size_t first = at(0, j, k);
  for (int e = 0; e < kGraphEdges; ++e) {
    row.weights[e] = edges(e, first);
    row.offsets[e] = offset(e);
  }
  row.leak = leak_.row(j, k);
  return row;
}

void PackedGraph::degrees(int j, int k, float* out) const {
  const std::size_t first = at(0, j, k);
  const auto count = as_size(row_length());
  std::copy_n(leak_.row(j, k), count, out);
  for (int e = 0; e < kGraphEdges; ++e) {
    const std::uint16_t* after = edges(e, first);
    const std::uint16_t* before = edges(e, first - static_cast<std::size_t>(offset(e)));
    for (std::size_t i = 0; i < count; ++i) {
      out[i] += unpacked_weight(after[i]) + unpacked_weight(before[i]);
    }
  }
}

PackedGraph PackedGraph::coarse(const std::array<int, 3>& factor, const RunOptions& run) const {
  std::array<int, 3> boxes{};
  for (std::size_t a = 0; a < 3; ++a) boxes[a] = (size()[a] - 1) / factor[a] + 1;
  PackedGraph out(boxes, FewRows(GraphLayout(boxes)));
  for (int k = 0; k < size()[2]; ++k) {
    for (int j = 0; j < size()[1]; ++j) {
      if (leak_.has(j, k)) out.leak_.writable(j / factor[1], k / factor[2]);
    }
  }
  std::array<std::vector<Leaving>, 8> leaving;
  for (int p = 0; p < 8; ++p)
    leaving[as_size(p)] = leaving_edges({p & 1, p >> 1 & 1, p >> 2}, factor);

  const auto length = as_size(size()[0]);
  const auto along = as_size(factor[0]);
  using Sums = std::array<std::vector<float>, kGraphEdges>;
  const auto add_row = [&](int j, int k, Sums& sums) {
    const std::size_t first = at(0, j, k);
    for (std::size_t place = 0; place < along; ++place) {
      const int p = static_cast<int>(place) + 2 * (j % factor[1]) + 4 * (k % factor[2]);
      for (const Leaving& l : leaving[as_size(p)]) {
        const std::size_t back = l.forward ? 0 : static_cast<std::size_t>(offset(l.edge));
        const std::uint16_t* w = edges(l.edge, first - back);
        float* sum = sums[l.slot].data();
        for (std::size_t i = place; i < length; i += along) sum[i / along] += unpacked_weight(w[i]);
      }
    }
    if (!leak_.has(j, k)) return;
    const float* leak = leak_.row(j, k);
    float* sum = out.leak_.writable(j / factor[1], k / factor[2]);
    for (std::size_t i = 0; i < length; ++i) sum[i / along] += leak[i];
  };
  for_each_plane(boxes[2], run, [&](int bk) {
    Sums sums;
    for (int bj = 0; bj < boxes[1]; ++bj) {
      for (auto& sum : sums) sum.assign(as_size(boxes[0]), 0.0F);
      for (int k = bk * factor[2]; k < std::min((bk + 1) * factor[2], size()[2]); ++k) {
        for (int j = bj * factor[1]; j < std::min((bj + 1) * factor[1], size()[1]); ++j) {
          add_row(j, k, sums);
        }
      }
      for (std::size_t e = 0; e < sums.size(); ++e) {
        std::ranges::transform(sums[e], &out.weights_[e][out.at(0, bj, bk)], packed_weight);
      }
    }
  });
  return out;
}

std::array<double, 3> PackedGraph::coupling(const RunOptions& run) const {
  std::vector<std::array<double, 3>> planes(as_size(size()[2]));
  for_each_plane(size()[2], run, [&](int k) {
    std::array<double, 3> sum{};
    for (int j = 0; j < size()[1]; ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        const std::uint16_t* w = edges(axis, at(0, j, k));
        float row = 0;
        for (int i = 0; i < size()[0]; ++i) row += unpacked_weight(w[i]);
        sum[as_size(axis)] += static_cast<double>(row);
      }
    }
    planes[as_size(k)] = sum;
  });
  std::array<double, 3> mean{};
  for (const auto& plane : planes) {
    for (std::size_t a = 0; a < 3; ++a) mean[a] += plane[a];
  }
  const double nodes = static_cast<double>(size()[0]) * size()[1] * size()[2];
  for (double& m : mean) m /= nodes;
  return mean;
}

}  // namespace nav::render::features
