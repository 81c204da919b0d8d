// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

#include "render/features/graph_layout.hpp"

namespace nav::render::features {

/// The matrix of a graph in double, for direct solves. Private to the solver.
struct GraphMatrix {
  std::vector<std::size_t> nodes;  ///< Nodes of the matrix rows.
  Eigen::VectorXd degree;  ///< Sums of the edges; 0: there is nothing to solve, and the row is that
                           ///< of the identity.
  Eigen::SparseMatrix<double> matrix;
};

/// \p weight: weight(edge, node) is the weight of the edge that begins at node. \p whisper:
/// relative excess of the diagonal.
template <class Weight>
GraphMatrix matrix_of(const GraphLayout& layout, const FewRows& leak, const Weight& weight,
                      double whisper) {
  GraphMatrix out;
  std::vector<int> number(layout.cells(), -1);
  std::vector<double> degree;
  for (int k = 0; k < layout.size()[2]; ++k) {
    for (int j = 0; j < layout.size()[1]; ++j) {
      for (int i = 0; i < layout.size()[0]; ++i) {
        const std::size_t node = layout.at(i, j, k);
        number[node] = static_cast<int>(out.nodes.size());
        out.nodes.push_back(node);
        degree.push_back(static_cast<double>(leak.row(j, k)[i]));
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(out.nodes.size());
  out.degree = Eigen::Map<const Eigen::VectorXd>(degree.data(), size);
  std::vector<Eigen::Triplet<double>> entries;
  for (const std::size_t node : out.nodes) {
    for (int e = 0; e < kGraphEdges; ++e) {
      const auto w = static_cast<double>(weight(e, node));
      if (!(w > 0)) continue;
      const int row = number[node];
      const int other = number[node + static_cast<std::size_t>(layout.offset(e))];
      for (const int end : {row, other}) out.degree[end] += w;
      entries.emplace_back(row, other, -w);
      entries.emplace_back(other, row, -w);
    }
  }
  for (int row = 0; row < size; ++row) {
    const double sum = out.degree[row];
    entries.emplace_back(row, row, sum > 0 ? sum * (1 + whisper) : 1);
  }
  out.matrix.resize(size, size);
  out.matrix.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace nav::render::features
