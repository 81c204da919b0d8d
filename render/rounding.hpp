// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nav::render {

/// Half of the range of an int32, for integrals kept as int32: a sum of two cannot overflow.
inline constexpr double kLargestIntegral = 1 << 30;

/// Equals std::lround() for x in [0, 2^31 - 1], without a call: tables have thousands of entries.
inline std::int32_t rounded(double x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole + (x - whole >= 0.5 ? 1 : 0);
}

}  // namespace nav::render
