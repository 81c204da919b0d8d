// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nav {

/// Increment of the splitmix64 state.
inline constexpr std::uint64_t kHashStep = 0x9e3779b97f4a7c15ULL;

/// Counter-based random bits: the finaliser of splitmix64 (Steele, Lea, Flood 2014). A key gives
/// the same bits on every thread and machine.
constexpr std::uint64_t hash_bits(std::uint64_t key) {
  key += kHashStep;
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebULL;
  return key ^ (key >> 31);
}

}  // namespace nav
