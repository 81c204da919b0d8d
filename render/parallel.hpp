// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace nav::render {

/// Calls work(i) for i in [0, count) on at most this many threads; 0: all cores. work must not
/// depend on the order of the calls.
template <class Work>
void for_each_index(int count, int threads, const Work& work) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] { tbb::parallel_for(0, count, work); });
}

}  // namespace nav::render
