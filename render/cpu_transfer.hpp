// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "render/cpu_march.hpp"
#include "render/cpu_volume.hpp"
#include "render/transfer_function.hpp"

namespace nav::render {

/// A transfer function tabulated at every whole HU between its end nodes, within the range of
/// int16, linear in between. Exact when the nodes lie on whole HU.
class CpuTransfer {
 public:
  explicit CpuTransfer(const TransferFunction& transfer);
  [[nodiscard]] const TableEntry* entries() const { return entries_.data(); }
  [[nodiscard]] int size() const { return static_cast<int>(entries_.size()); }
  /// HU of the first and of the last entry.
  [[nodiscard]] float low_hu() const { return static_cast<float>(low_); }
  [[nodiscard]] float high_hu() const { return static_cast<float>(high_); }
  /// Up to here nothing is visible, HU; -infinity when the first entry is.
  [[nodiscard]] float invisible_up_to_hu() const;
  /// Whether every value in [min, max] HU, give or take one, is invisible.
  [[nodiscard]] bool invisible(int min_hu, int max_hu) const;

 private:
  int low_ = 0;
  int high_ = 0;
  std::vector<TableEntry> entries_;
  std::vector<int> visible_before_;  ///< Visible entries before each index.
};

/// For every brick the Chebyshev distance, in bricks, to the nearest one where something is
/// visible: 0 there, at most 255.
struct BrickDistances {
  std::vector<std::uint8_t> distance;  ///< And 3 bytes that nobody counts.
  int occupied = 0;
};
BrickDistances brick_distances(const CpuVolume& volume, const CpuTransfer& transfer);

}  // namespace nav::render
