// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>

#include "nav/result.hpp"

namespace nav::render::features {

/// How a derived volume is computed; never what comes out: the same bytes for any number of
/// threads.
struct RunOptions {
  int threads = 0;                       ///< At most; 0: all cores.
  std::stop_token stop{};                ///< Asked between planes and between iterations.
  std::function<void(double)> progress;  ///< Share done, [0, 1]; from any worker, or empty.
  /// A computation that would hold more than this, its result included, is refused, bytes.
  std::size_t memory_limit = std::size_t{6} << 30;
};

/// A refusal that names the volume and both sizes when needed exceeds the limit.
Result<void> check_memory(const std::string& what, std::size_t voxels, double bytes_per_voxel,
                          std::size_t limit);

/// kCancelled, naming what was stopped.
Error cancelled(const std::string& what);

/// Counts steps done by many workers.
class Steps {
 public:
  Steps(const RunOptions& run, std::size_t total) : run_(run), total_(total) {}
  /// False: stop, the caller asked for it.
  bool next() {
    if (run_.stop.stop_requested()) return false;
    const std::size_t done = ++done_;
    if (run_.progress) run_.progress(static_cast<double>(done) / static_cast<double>(total_));
    return true;
  }
  [[nodiscard]] bool stopped() const { return run_.stop.stop_requested(); }

 private:
  const RunOptions& run_;
  std::size_t total_;
  std::atomic<std::size_t> done_ = 0;
};

}  // namespace nav::render::features
