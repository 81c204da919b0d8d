// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nav/time.hpp"

namespace nav::session {

/// Times between the arrivals of a stream's samples. Takes no memory per sample. Not thread-safe.
class StreamTiming {
 public:
  /// \p sequence: the sample's number in its stream; numbers that are left out are missing.
  void add(Timestamp received, std::uint64_t sequence);

  struct Summary {
    double rate_hz = 0;        ///< Over all samples; 0 before the second.
    double period_p50_ms = 0;  ///< Percentiles over the newest kKept periods; 0 without any.
    double period_p95_ms = 0;
    double period_p99_ms = 0;
    double period_max_ms = 0;   ///< Over all samples.
    std::uint64_t missing = 0;  ///< Numbers that were left out.
  };
  [[nodiscard]] Summary summary() const;

 private:
  static constexpr std::size_t kKept = 2048;

  std::array<float, kKept> periods_ms_{};
  std::uint64_t count_ = 0;
  std::uint64_t missing_ = 0;
  double longest_ms_ = 0;
  std::optional<Timestamp> first_, newest_;
  std::uint64_t newest_sequence_ = 0;
};

}  // namespace nav::session
