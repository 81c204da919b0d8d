// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/derived/grid_graph.hpp"
#include "render/parallel.hpp"

namespace nav::render::derived {

/// Calls work(j, k, first node) for every row, planes in parallel. Private to the solver.
template <class Work>
void for_each_row(const GridGraph& graph, int threads, const Work& work) {
  for_each_index(graph.size()[2], threads, [&](int k) {
    for (int j = 0; j < graph.size()[1]; ++j) work(j, k, graph.at(0, j, k));
  });
}

}  // namespace nav::render::derived
