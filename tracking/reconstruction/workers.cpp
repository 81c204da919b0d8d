// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/workers.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "nav/threads.hpp"

namespace nav::tracking {

struct Workers::Arena {
  tbb::task_arena tasks;
};

Workers::Workers(int threads)
    : arena_(new Arena{
          tbb::task_arena(threads > 0 ? usable_threads(threads) : tbb::task_arena::automatic)}) {}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;

void Workers::run(int count, const std::function<void(int)>& work) const {
  if (count == 1) return work(0);
  arena_->tasks.execute([&] { tbb::parallel_for(0, count, work); });
}

}  // namespace nav::tracking
