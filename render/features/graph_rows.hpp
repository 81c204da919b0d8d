// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/features/graph_layout.hpp"
#include "render/features/run.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {

/// Calls work(i) for i in [0, count) in parallel until a stop is requested. After a stop, the
/// results are invalid. Private to the solver.
template <class Work>
void for_each_plane(int count, const RunOptions& run, const Work& work) {
  for_each_index(count, run.threads, [&](int i) {
    if (!run.stop.stop_requested()) work(i);
  });
}

inline Products& operator+=(Products& a, const Products& b) {
  a.zz += b.zz;
  a.rz += b.rz;
  return a;
}
/// Adds the parts in order, so that the sum is the same for any number of threads.
inline Products sum_of(const std::vector<Products>& parts) {
  Products sum{};
  for (const Products& part : parts) sum += part;
  return sum;
}

/// Calls work(j, k, first node) for every row, planes in parallel. Private to the solver.
template <class Work>
void for_each_row(const GraphLayout& graph, const RunOptions& run, const Work& work) {
  for_each_plane(graph.size()[2], run, [&](int k) {
    for (int j = 0; j < graph.size()[1]; ++j) work(j, k, graph.at(0, j, k));
  });
}

}  // namespace nav::render::features
