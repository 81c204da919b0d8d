// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "sim/random.hpp"

namespace nav::sim {

/// Point scatterers that are fixed in the tissue: one in each cell of a lattice along the CT axes.
/// A hash of the cell gives its position and strength. Private to sim/. Thread-safe.
class ScattererCells {
 public:
  ScattererCells(std::uint64_t seed, double cell_mm) : seed_(seed), cell_mm_(cell_mm) {}
  [[nodiscard]] double cell_mm() const { return cell_mm_; }
  /// Random bits of a cell's scatterer, for place() and strength().
  [[nodiscard]] std::uint64_t bits(const Eigen::Vector3i& cell) const {
    const auto part = [](int i) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(i));
    };
    return hash_bits(seed_ ^ (part(cell.x()) * 0x8da6b343d8163841ULL) ^
                     (part(cell.y()) * 0xd8163841cb1ab31fULL) ^
                     (part(cell.z()) * 0xcb1ab31f8da6b343ULL));
  }
  /// Position within the cell, [0, 1) of the cell size.
  [[nodiscard]] static Eigen::Vector3d place(std::uint64_t bits) {
    return {share(bits, 0), share(bits, 16), share(bits, 32)};
  }
  /// Strength with mean 0 and unit variance, nearly normal: a sum of four uniform numbers.
  [[nodiscard]] static double strength(std::uint64_t bits) {
    constexpr double kSqrt3 = 1.7320508;
    const std::uint64_t more = hash_bits(bits);
    return (share(more, 0) + share(more, 16) + share(more, 32) + share(more, 48) - 2.0) * kSqrt3;
  }
  /// Index of the cell at a coordinate of one axis.
  [[nodiscard]] int index(double mm) const { return static_cast<int>(std::floor(mm / cell_mm_)); }

 private:
  static double share(std::uint64_t word, int shift) {
    return static_cast<double>((word >> shift) & 0xffff) * 0x1p-16;
  }
  std::uint64_t seed_;
  double cell_mm_;
};

}  // namespace nav::sim
