// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace nav {

/// Scan line at a voxel in 64 bits: unit direction away from the transducer in the frame of the
/// volume (error below 3e-5 rad) and depth along the line (steps of 1/64 mm, -512 to 512 mm).
struct ScanLineAtVoxel {
  /// x, y and z of the direction times 32767, depth in 1/64 mm; a zero direction: undefined.
  std::array<std::int16_t, 4> words{};

  /// \p away: a unit vector. A depth beyond 511 mm is set to the nearer limit.
  static ScanLineAtVoxel pack(const Eigen::Vector3d& away, double depth_mm) {
    constexpr double kMostMm = 511;
    const double depth = std::min(std::max(depth_mm, -kMostMm), kMostMm);
    const auto word = [](double v) { return static_cast<std::int16_t>(std::lround(v)); };
    return {{word(kUnit * away.x()), word(kUnit * away.y()), word(kUnit * away.z()),
             word(kPerMm * depth)}};
  }
  [[nodiscard]] bool defined() const { return words[0] != 0 || words[1] != 0 || words[2] != 0; }
  /// Unit vector. Precondition: defined().
  [[nodiscard]] Eigen::Vector3d away() const {
    return Eigen::Vector3d(words[0], words[1], words[2]).normalized();
  }
  [[nodiscard]] double depth_mm() const { return words[3] / kPerMm; }

  friend bool operator==(const ScanLineAtVoxel&, const ScanLineAtVoxel&) = default;

 private:
  static constexpr double kUnit = 32767;
  static constexpr double kPerMm = 64;
};

}  // namespace nav
