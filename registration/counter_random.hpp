// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nav/hash_bits.hpp"

namespace nav::registration {

/// splitmix64, a counter-based generator (Steele, Lea, Flood 2014), as a fraction in [0, 1). The
/// same counter gives the same bits on every machine.
constexpr double fraction(std::uint64_t counter) {
  return static_cast<double>(hash_bits(counter * kHashStep) >> 11) * 0x1.0p-53;
}

}  // namespace nav::registration
