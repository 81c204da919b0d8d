// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::bench {

/// Throughput of one codec on one core: bytes that came are found as messages, checked and decoded.
struct CodecRun {
  std::string codec;         ///< "openigtlink image", "ndi TX", "ndi BX2", …
  std::size_t bytes = 0;     ///< Bytes of one message.
  double per_second = 0;     ///< Messages per second of processor time.
  double mb_per_second = 0;  ///< Megabytes (10^6 bytes) per second of processor time.
  std::string goal;          ///< Goal of per_second or mb_per_second; empty: none.
};

/// \p seconds: processor time for each codec, in (0, 60].
Result<std::vector<CodecRun>> measure_codecs(double seconds);
std::string to_text(const std::vector<CodecRun>& rows);

}  // namespace nav::bench
