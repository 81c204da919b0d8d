// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "nav/hash_bits.hpp"

namespace nav::sim {

using nav::hash_bits;

/// Random bits of a stream of a seed, indexed by a counter.
constexpr std::uint64_t hash_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  return hash_bits(hash_bits(hash_bits(seed) ^ stream) ^ counter);
}

/// Converts bits to a uniform number in (0, 1].
constexpr double unit_from_bits(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 1.0) * 0x1.0p-53;
}

/// Standard normal number by Box-Muller, indexed by a counter.
inline double normal_at(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  const double u = unit_from_bits(hash_bits(seed, stream, 2 * counter));
  const double v = unit_from_bits(hash_bits(seed, stream, 2 * counter + 1));
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

/// Sequence of random numbers; used only during construction.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}
  /// Uniform in [low, high].
  double uniform(double low, double high) {
    return low + (high - low) * unit_from_bits(hash_bits(seed_, stream_, counter_++));
  }
  /// Uniformly distributed unit vector.
  Eigen::Vector3d direction() {
    const double z = uniform(-1, 1);
    const double turn = uniform(0, 2 * std::numbers::pi);
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  /// Vector whose components are uniform in [-half, half].
  Eigen::Vector3d offset(double half) {
    const double x = uniform(-half, half);
    const double y = uniform(-half, half);
    return {x, y, uniform(-half, half)};
  }

 private:
  std::uint64_t seed_;
  std::uint64_t stream_;
  std::uint64_t counter_ = 0;
};

}  // namespace nav::sim
