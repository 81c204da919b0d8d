// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>

#include "sim/random.hpp"

namespace nav::sim {

/// Scatterers that are fixed in the tissue: every cell of an oblique lattice in CT space has one
/// complex number of unit mean power, given by a hash of its position. Blurred with the beam they
/// give fully developed speckle (Goodman 1975). Thread-safe.
class SpeckleField {
 public:
  SpeckleField(std::uint64_t seed, double cell_mm)
      // The lattice is oblique, so that no usual image plane (axial, sagittal) runs along a layer
      // of cells.
      : rotation_(Eigen::AngleAxisd(0.83, Eigen::Vector3d(0.36, 0.48, 0.8)).toRotationMatrix()),
        seed_(hash_bits(seed ^ 0x737065636b6c65)),
        cells_per_mm_(1.0 / cell_mm) {}
  /// Matrix of to_cells().
  [[nodiscard]] Eigen::Matrix3d cells_from_mm() const { return cells_per_mm_ * rotation_; }

  [[nodiscard]] double cell_mm() const { return 1.0 / cells_per_mm_; }
  /// Converts a CT position or direction to lattice cells. Scan lines are followed in these units.
  [[nodiscard]] Eigen::Vector3d to_cells(const Eigen::Vector3d& mm) const {
    return cells_per_mm_ * (rotation_ * mm);
  }
  [[nodiscard]] std::complex<float> at(const Eigen::Vector3d& cells) const {
    const auto index = [](double v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)));
    };
    const std::uint64_t bits = hash_bits(seed_ ^ (index(cells.x()) * 0x8da6b343d8163841ULL) ^
                                         (index(cells.y()) * 0xd8163841cb1ab31fULL) ^
                                         (index(cells.z()) * 0xcb1ab31f8da6b343ULL));
    // Each part is a sum of two uniform 16-bit numbers: mean 65535, variance 2 (2^32 - 1) / 12.
    constexpr float kUnitPower = 1.0F / 37837.2F;
    const auto part = [bits](int shift) { return static_cast<float>((bits >> shift) & 0xffff); };
    return {(part(0) + part(16) - 65535.0F) * kUnitPower,
            (part(32) + part(48) - 65535.0F) * kUnitPower};
  }

 private:
  Eigen::Matrix3d rotation_;
  std::uint64_t seed_;
  double cells_per_mm_;
};

/// Smooth random field in [-1, 1] in CT space (trilinear value noise). Thread-safe.
class SmoothField {
 public:
  SmoothField(std::uint64_t seed, double cell_mm) : seed_(hash_bits(seed)), cell_mm_(cell_mm) {}
  [[nodiscard]] float at(const Eigen::Vector3d& mm) const {
    const Eigen::Vector3d q = mm / cell_mm_;
    const Eigen::Vector3d low = q.array().floor();
    const Eigen::Vector3d t = q - low;
    const Eigen::Vector3i first = low.cast<int>();
    std::array<std::uint64_t, 4> columns;  // Bits of node() after the steps for x and y.
    for (int i = 0; i < 2; ++i) {
      const std::uint64_t row = next(seed_, first.x() + i);
      for (int j = 0; j < 2; ++j) {
        columns[static_cast<std::size_t>(i + 2 * j)] = next(row, first.y() + j);
      }
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3i side(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
      double weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= side[axis] == 1 ? t[axis] : 1 - t[axis];
      const std::uint64_t column = columns[static_cast<std::size_t>(corner & 3)];
      sum += weight * static_cast<double>(value_of(next(column, first.z() + side.z())));
    }
    return static_cast<float>(sum);
  }
  /// Value at index * cell_mm(), in [-1, 1].
  [[nodiscard]] float node(const Eigen::Vector3i& index) const {
    return value_of(next(next(next(seed_, index.x()), index.y()), index.z()));
  }
  [[nodiscard]] double cell_mm() const { return cell_mm_; }

 private:
  static std::uint64_t next(std::uint64_t bits, int index) {
    return hash_bits(bits ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(index)));
  }
  static float value_of(std::uint64_t bits) {
    return static_cast<float>(2 * unit_from_bits(bits) - 1);
  }
  std::uint64_t seed_;
  double cell_mm_;
};

}  // namespace nav::sim
