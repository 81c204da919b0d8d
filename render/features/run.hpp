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

/// Options of a computation of a derived volume. They never change the result: it has the same
/// bytes for any number of threads.
struct RunOptions {
  int threads = 0;                       ///< Greatest number of threads; 0: all cores.
  std::stop_token stop{};                ///< Checked between planes and between iterations.
  std::function<void(double)> progress;  ///< Receives the share done, [0, 1], from any worker
                                         ///< thread; may be empty.
  /// Greatest memory of a computation, its result included, bytes. A larger one is rejected.
  std::size_t memory_limit = std::size_t{6} << 30;
};

/// Error if the needed memory exceeds the limit. It names the volume and both sizes.
Result<void> check_memory(const std::string& what, std::size_t voxels, double bytes_per_voxel,
                          std::size_t limit);

/// The error kCancelled, with the name of the stopped computation.
Error cancelled(const std::string& what);

/// Counts the steps that several workers have done.
class Steps {
 public:
  Steps(const RunOptions& run, std::size_t total) : run_(run), total_(total) {}
  /// False when the caller requested a stop.
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
