// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/features/kernels.hpp"

namespace nav::render::features {

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

/// Where the nodes of a grid lie in a vector over them: rows of a border of nodes without edges
/// around, so that no loop asks where the grid ends.
class GraphLayout {
 public:
  explicit GraphLayout(const std::array<int, 3>& size);
  /// cells() of a grid of that size: many times its nodes where it is thin.
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
  /// From a node to the one that its edge, [0, kGraphEdges), leads to.
  [[nodiscard]] std::ptrdiff_t offset(int edge) const {
    return offsets_[static_cast<std::size_t>(edge)];
  }
  /// Nodes of a row that kernels run over.
  [[nodiscard]] int row_length() const { return padded(size_[0]); }

 private:
  std::array<int, 3> size_;
  int stride_;
  std::size_t cells_;
  std::array<std::ptrdiff_t, kGraphEdges> offsets_{};
};

/// Values of nodes that are 0 in most rows, as edges to nodes whose value is fixed are: only rows
/// that were asked for to write to take memory.
class FewRows {
 public:
  explicit FewRows(const GraphLayout& layout);
  /// row_length() values.
  [[nodiscard]] const float* row(int j, int k) const {
    return &values_[static_cast<std::size_t>(slot_[number(j, k)]) * length_];
  }
  [[nodiscard]] bool has(int j, int k) const { return slot_[number(j, k)] != 0; }
  /// A row to write to, valid until another one is asked for. Those that has() already may be asked
  /// for and written by several threads.
  float* writable(int j, int k);
  /// Of all values as a vector.
  [[nodiscard]] double norm() const;

 private:
  [[nodiscard]] std::size_t number(int j, int k) const {
    return static_cast<std::size_t>(k) * rows_ + static_cast<std::size_t>(j);
  }
  std::size_t rows_, length_;       ///< Of a plane, of a row.
  std::vector<std::int32_t> slot_;  ///< Of each row; 0: the row of zeros.
  std::vector<float> values_;
};

}  // namespace nav::render::features
