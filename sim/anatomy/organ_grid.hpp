// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/anatomy/organ.hpp"

namespace nav::sim {

/// Organs to evaluate at a point, by index, lowest first.
struct OrgansNear {
  std::span<const std::uint16_t> indices;
  bool first_fills = false;  ///< The first fills the neighbourhood and is not evaluated.
};

/// Grid of the organs that matter at each position. Each cell lists the organs whose surface is
/// near, on top of the last organ that fills the whole cell. Cells with few surfaces are split into
/// eight. Private to sim/. Reading is thread-safe.
class OrganGrid {
 public:
  /// \p organs must outlive the grid; their surfaces lie within \p box.
  OrganGrid(const std::vector<Organ>& organs, const Eigen::AlignedBox3d& box, double cell_mm = 5);
  /// Organs near a point; outside the box all of them.
  [[nodiscard]] OrgansNear organs_at(const Eigen::Vector3d& p) const;

 private:
  struct Cell {
    std::uint32_t start = 0;  ///< Start of its list; of its eight children if it is split.
    std::uint16_t count = 0;
    bool filled = false;
    bool split = false;
  };
  /// Cell under construction.
  struct Found {
    std::vector<std::uint16_t> organs;
    bool filled = false;
    void add(std::uint16_t organ, double distance_mm, double reach_mm);
  };
  [[nodiscard]] std::vector<Found> fill(const std::vector<Organ>& organs) const;
  /// Eight children of a cell, x fastest.
  [[nodiscard]] std::vector<Found> split(const std::vector<Organ>& organs, const Found& cell,
                                         const Eigen::Vector3d& corner) const;
  Cell keep(const Found& found);

  Eigen::AlignedBox3d box_;
  double cell_mm_, cells_per_mm_;
  Eigen::Array3i size_;
  std::vector<Cell> cells_;
  std::vector<Cell> children_;  ///< Groups of eight, x fastest.
  std::vector<std::uint16_t> lists_;
  std::vector<std::uint16_t> all_;
};

}  // namespace nav::sim
