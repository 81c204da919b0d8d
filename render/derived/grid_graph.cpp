// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived/grid_graph.hpp"

#include <algorithm>

#include "nav/index.hpp"
#include "render/derived/graph_rows.hpp"

namespace nav::render::derived {
namespace {

/// An edge that leaves its box.
struct Leaving {
  std::size_t edge;
  bool forward;      ///< From the node that it is stored at, or towards it.
  std::size_t slot;  ///< Of kEdgeSteps for the boxes; kGraphEdges: stored at the other box.
};

/// Where the edges of a node lead, by its place in its box.
std::vector<Leaving> leaving_edges(const std::array<int, 3>& place,
                                   const std::array<int, 3>& factor) {
  std::vector<Leaving> found;
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    for (const int sign : {1, -1}) {
      std::array<int, 3> step{};
      for (std::size_t a = 0; a < 3; ++a) {
        // Within [-1, 2]; + factor: rounds down below 0 too.
        step[a] = (place[a] + sign * kEdgeSteps[e][a] + factor[a]) / factor[a] - 1;
      }
      const auto slot = std::find(kEdgeSteps.begin(), kEdgeSteps.end(), step) - kEdgeSteps.begin();
      if (slot == kGraphEdges) continue;  // Inside the box, or the other box will add it.
      found.push_back({e, sign == 1, static_cast<std::size_t>(slot)});
    }
  }
  return found;
}

}  // namespace

std::size_t GridGraph::cells_of(const std::array<int, 3>& size) {
  const std::size_t row = as_size(padded(size[0]) + kLanes);
  return row * (as_size(size[1]) + 2) * (as_size(size[2]) + 2) + 2 * kLanes;
}

GridGraph::GridGraph(const std::array<int, 3>& size)
    : size_(size), stride_(padded(size[0]) + kLanes), cells_(cells_of(size)) {
  const std::size_t plane = as_size(stride_) * as_size(size[1] + 2);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    const auto& s = kEdgeSteps[e];
    offsets_[e] = s[0] + s[1] * stride_ + s[2] * static_cast<std::ptrdiff_t>(plane);
    weights[e] = ZeroedArray<float>(cells_);
  }
  leak = ZeroedArray<float>(cells_);
}

GraphRow GridGraph::row(int j, int k) const {
  GraphRow row{};
  const std::size_t first = at(0, j, k);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    row.weights[e] = weights[e].data() + first;
    row.offsets[e] = offsets_[e];
  }
  row.leak = leak.data() + first;
  return row;
}

double GridGraph::degree(std::size_t node) const {
  double sum = static_cast<double>(leak[node]);
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    sum += static_cast<double>(weights[e][node]);
    sum += static_cast<double>(weights[e][node - static_cast<std::size_t>(offsets_[e])]);
  }
  return sum;
}

GridGraph GridGraph::coarse(const std::array<int, 3>& factor, const RunOptions& run) const {
  std::array<int, 3> boxes{};
  for (std::size_t a = 0; a < 3; ++a) boxes[a] = (size_[a] - 1) / factor[a] + 1;
  GridGraph out(boxes);
  std::array<std::vector<Leaving>, 8> leaving;
  for (int p = 0; p < 8; ++p)
    leaving[as_size(p)] = leaving_edges({p & 1, p >> 1 & 1, p >> 2}, factor);
  const auto add_node = [&](int i, int j, int k) {
    const std::size_t node = at(i, j, k);
    const std::size_t box = out.at(i / factor[0], j / factor[1], k / factor[2]);
    out.leak[box] += leak[node];
    const int place = i % factor[0] + 2 * (j % factor[1]) + 4 * (k % factor[2]);
    for (const Leaving& l : leaving[as_size(place)]) {
      const std::size_t at_node =
          l.forward ? node : node - static_cast<std::size_t>(offsets_[l.edge]);
      out.weights[l.slot][box] += weights[l.edge][at_node];
    }
  };
  for_each_plane(boxes[2], run, [&](int bk) {
    for (int k = bk * factor[2]; k < std::min((bk + 1) * factor[2], size_[2]); ++k) {
      for (int j = 0; j < size_[1]; ++j) {
        for (int i = 0; i < size_[0]; ++i) add_node(i, j, k);
      }
    }
  });
  return out;
}

std::array<double, 3> GridGraph::coupling(const RunOptions& run) const {
  std::vector<std::array<double, 3>> planes(as_size(size_[2]));
  for_each_plane(size_[2], run, [&](int k) {
    std::array<double, 3> sum{};
    for (int j = 0; j < size_[1]; ++j) {
      const std::size_t first = at(0, j, k);
      for (std::size_t a = 0; a < 3; ++a) {
        float row = 0;
        for (std::size_t i = 0; i < as_size(size_[0]); ++i) row += weights[a][first + i];
        sum[a] += static_cast<double>(row);
      }
    }
    planes[as_size(k)] = sum;
  });
  std::array<double, 3> mean{};
  for (const auto& plane : planes) {
    for (std::size_t a = 0; a < 3; ++a) mean[a] += plane[a];
  }
  const double nodes = static_cast<double>(size_[0]) * size_[1] * size_[2];
  for (double& m : mean) m /= nodes;
  return mean;
}

}  // namespace nav::render::derived
