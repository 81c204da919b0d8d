// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

namespace nav::render {

/// How long the device takes for commands; needs the context current, also to be released. Internal
/// to render/.
class GlTimer {
 public:
  GlTimer() = default;
  ~GlTimer() { release(); }
  GlTimer(const GlTimer&) = delete;
  GlTimer& operator=(const GlTimer&) = delete;

  /// by_clock: waits for the device before and after, and takes the time of the system's clock;
  /// software rasterisers know no other. Else the device notes the times, which waits once.
  void begin(bool by_clock);
  /// Since begin(), s. Waits for the device.
  double end_s();
  void release();

 private:
  std::array<unsigned, 2> queries_{};  ///< Their times.
  std::chrono::steady_clock::time_point start_;
  bool by_clock_ = true;
};

}  // namespace nav::render
