// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

namespace nav::render {

/// Measures how long the device takes for commands. Needs the context current, also for release().
/// Internal to render/.
class GlTimer {
 public:
  GlTimer() = default;
  ~GlTimer() { release(); }
  GlTimer(const GlTimer&) = delete;
  GlTimer& operator=(const GlTimer&) = delete;

  /// Starts the measurement. by_clock: waits for the device before and after, and uses the system's
  /// clock; software rasterisers support nothing else. Otherwise the device records the times,
  /// which waits once.
  void begin(bool by_clock);
  /// Time since begin(), s. Waits for the device.
  double end_s();
  void release();

 private:
  std::array<unsigned, 2> queries_{};  ///< They record the two times.
  std::chrono::steady_clock::time_point start_;
  bool by_clock_ = true;
};

}  // namespace nav::render
