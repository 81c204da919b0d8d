// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/features/kernels.hpp"

namespace nav::render::features {

/// Steps to the neighbours for which an edge is stored: three along the axes, six along the
/// diagonals of the planes of the axes. With the opposite steps these are 18 neighbours.
inline constexpr std::array<std::array<int, 3>, kGraphEdges> kEdgeSteps{{{1, 0, 0},
                                                                         {0, 1, 0},
                                                                         {0, 0, 1},
                                                                         {1, 1, 0},
                                                                         {1, -1, 0},
                                                                         {1, 0, 1},
                                                                         {1, 0, -1},
                                                                         {0, 1, 1},
                                                                         {0, 1, -1}}};

/// Positions of a grid's nodes in a vector over the nodes. A border of nodes without edges
/// surrounds the grid, so that no loop has to test for the end of the grid.
class GraphLayout {
 public:
  explicit GraphLayout(const std::array<int, 3>& size);
  /// Number of cells() for a grid of a size. For a thin grid it is many times the number of nodes.
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
  /// Offset from a node to the node at the end of its edge, [0, kGraphEdges).
  [[nodiscard]] std::ptrdiff_t offset(int edge) const {
    return offsets_[static_cast<std::size_t>(edge)];
  }
  /// Number of nodes of a row that kernels process.
  [[nodiscard]] int row_length() const { return padded(size_[0]); }

 private:
  std::array<int, 3> size_;
  int stride_;
  std::size_t cells_;
  std::array<std::ptrdiff_t, kGraphEdges> offsets_{};
};

/// Node values that are 0 in most rows, such as the sums of edges to nodes with a fixed value. Only
/// rows that were requested for writing take memory.
class FewRows {
 public:
  explicit FewRows(const GraphLayout& layout);
  /// The values of a row; row_length() of them.
  [[nodiscard]] const float* row(int j, int k) const {
    return &values_[static_cast<std::size_t>(slot_[number(j, k)]) * length_];
  }
  [[nodiscard]] bool has(int j, int k) const { return slot_[number(j, k)] != 0; }
  /// A row for writing, valid until another new row is requested. Several threads may request and
  /// write rows for which has() is already true.
  float* writable(int j, int k);
  /// Norm of all values as a vector.
  [[nodiscard]] double norm() const;

 private:
  [[nodiscard]] std::size_t number(int j, int k) const {
    return static_cast<std::size_t>(k) * rows_ + static_cast<std::size_t>(j);
  }
  std::size_t rows_, length_;       ///< Number of rows in a plane; number of values in a row.
  std::vector<std::int32_t> slot_;  ///< Slot of each row; 0: the row of zeros.
  std::vector<float> values_;
};

}  // namespace nav::render::features
