// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived/grid_graph.hpp"

#include "render/parallel.hpp"

namespace nav::render::derived {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Weights from one box of nodes to the 27 boxes around it.
class BoxEdges {
 public:
  void add(const std::array<int, 3>& step, float weight) {
    sums_[index(9 * (step[2] + 1) + 3 * (step[1] + 1) + step[0] + 1)] +=
        static_cast<double>(weight);
  }
  [[nodiscard]] float to(const std::array<int, 3>& step) const {
    return static_cast<float>(sums_[index(9 * (step[2] + 1) + 3 * (step[1] + 1) + step[0] + 1)]);
  }

 private:
  std::array<double, 27> sums_{};
};

}  // namespace

GridGraph::GridGraph(const std::array<int, 3>& size)
    : size_(size), stride_(padded(size[0]) + kLanes) {
  const std::size_t plane = index(stride_) * index(size[1] + 2);
  cells_ = plane * index(size[2] + 2) + 2 * kLanes;
  for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
    const auto& s = kEdgeSteps[e];
    offsets_[e] = s[0] + s[1] * stride_ + s[2] * static_cast<std::ptrdiff_t>(plane);
    weights[e].resize(cells_);
  }
  leak.resize(cells_);
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

GridGraph GridGraph::coarse(const std::array<int, 3>& factor, int threads) const {
  std::array<int, 3> boxes{};
  for (std::size_t a = 0; a < 3; ++a) boxes[a] = (size_[a] - 1) / factor[a] + 1;
  GridGraph out(boxes);
  const auto join = [&](int bi, int bj, int bk) {
    BoxEdges edges;
    double leaks = 0;
    for (int k = bk * factor[2]; k < std::min((bk + 1) * factor[2], size_[2]); ++k) {
      for (int j = bj * factor[1]; j < std::min((bj + 1) * factor[1], size_[1]); ++j) {
        for (int i = bi * factor[0]; i < std::min((bi + 1) * factor[0], size_[0]); ++i) {
          const std::size_t node = at(i, j, k);
          leaks += static_cast<double>(leak[node]);
          for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
            const auto& s = kEdgeSteps[e];
            // + factor: rounds down below 0 too.
            const auto box_step = [&](int sign) {
              return std::array<int, 3>{(i + sign * s[0] + factor[0]) / factor[0] - 1 - bi,
                                        (j + sign * s[1] + factor[1]) / factor[1] - 1 - bj,
                                        (k + sign * s[2] + factor[2]) / factor[2] - 1 - bk};
            };
            edges.add(box_step(1), weights[e][node]);
            edges.add(box_step(-1), weights[e][node - static_cast<std::size_t>(offsets_[e])]);
          }
        }
      }
    }
    const std::size_t box = out.at(bi, bj, bk);
    out.leak[box] = static_cast<float>(leaks);
    for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
      out.weights[e][box] = edges.to(kEdgeSteps[e]);
    }
  };
  for_each_index(boxes[2], threads, [&](int bk) {
    for (int bj = 0; bj < boxes[1]; ++bj) {
      for (int bi = 0; bi < boxes[0]; ++bi) join(bi, bj, bk);
    }
  });
  return out;
}

std::array<double, 3> GridGraph::coupling(int threads) const {
  std::vector<std::array<double, 3>> planes(index(size_[2]));
  for_each_index(size_[2], threads, [&](int k) {
    std::array<double, 3> sum{};
    for (int j = 0; j < size_[1]; ++j) {
      const std::size_t first = at(0, j, k);
      for (std::size_t a = 0; a < 3; ++a) {
        float row = 0;
        for (std::size_t i = 0; i < index(size_[0]); ++i) row += weights[a][first + i];
        sum[a] += static_cast<double>(row);
      }
    }
    planes[index(k)] = sum;
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
