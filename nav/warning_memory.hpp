// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>
#include <utility>

#include "nav/diagnostics.hpp"

namespace nav {

/// Passes reports on and remembers the first and the newest warning or error. Thread-safe.
class WarningMemory final : public Diagnostics {
 public:
  /// \p outer must outlive it.
  explicit WarningMemory(Diagnostics& outer) : outer_(outer) {}
  void take(const DiagnosticEntry& entry) override {
    if (entry.severity != Severity::kInfo) {
      const std::lock_guard lock(mutex_);
      newest_ = entry.message;
      if (first_.empty()) first_ = entry.message;
    }
    outer_.take(entry);
  }
  /// The first message of all; empty: none.
  [[nodiscard]] std::string first() const {
    const std::lock_guard lock(mutex_);
    return first_;
  }
  /// Forgets the messages so far.
  void forget() {
    const std::lock_guard lock(mutex_);
    first_.clear();
    newest_.clear();
  }
  /// The newest message since the last call; empty: none.
  std::string take_newest() {
    const std::lock_guard lock(mutex_);
    return std::exchange(newest_, {});
  }

 private:
  Diagnostics& outer_;
  mutable std::mutex mutex_;
  std::string first_;
  std::string newest_;
};

}  // namespace nav
