// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Runs one device on real time, and keeps what it reports.
template <class SourceKind>
struct SourceBench {
  /// Wait for what is certain to happen.
  static constexpr Duration kCertainly = std::chrono::seconds(20);

  /// The next sample; none if none comes.
  std::optional<Sample> sample() {
    const Timestamp end = clock.now() + kCertainly;
    while (clock.now() < end) {
      auto got = source->next(clock.now() + std::chrono::milliseconds(20));
      if (got) return *std::move(got);
    }
    return std::nullopt;
  }
  /// Runs the device until its health is as expected; false if it never is.
  bool until(const std::function<bool(const SourceHealth&)>& done) {
    const Timestamp end = clock.now() + kCertainly;
    while (clock.now() < end) {
      (void)source->next(clock.now() + std::chrono::milliseconds(5));
      if (done(source->health())) return true;
    }
    return false;
  }
  [[nodiscard]] std::string reports() const {
    std::string all;
    for (const auto& entry : diagnostics.entries()) all += entry.message + "\n";
    return all;
  }

  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  std::unique_ptr<SourceKind> source;
};

}  // namespace nav::devices
