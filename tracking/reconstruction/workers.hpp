// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace nav::tracking {

/// Threads that share the work of one caller at a time.
class Workers {
 public:
  /// \p threads: at most this many; 0: all cores.
  explicit Workers(int threads);
  ~Workers();
  Workers(Workers&&) noexcept;
  Workers& operator=(Workers&&) noexcept;

  /// Calls work(i) for i in [0, count), in any order, and waits for all calls.
  void run(int count, const std::function<void(int)>& work) const;

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;
};

}  // namespace nav::tracking
