// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>

#include "nav/result.hpp"
#include "render/interrupt.hpp"
#include "render/parallel.hpp"

namespace nav::render {

/// for_each_index() that asks before each call whether to go on. False: it was interrupted, and
/// some calls were left out.
template <class Work>
bool for_each_index(int count, int threads, const Interrupt& interrupt, const Work& work) {
  std::atomic<bool> interrupted{false};
  for_each_index(count, threads, [&](int i) {
    if (interrupted.load(std::memory_order_relaxed)) return;
    if (interrupt.requested()) {
      interrupted.store(true, std::memory_order_relaxed);
    } else {
      work(i);
    }
  });
  return !interrupted;
}

/// The error of an engine whose image was interrupted.
Error interrupted_error(const std::string& engine);

}  // namespace nav::render
