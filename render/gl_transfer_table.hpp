// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/transfer_function.hpp"

namespace nav::render {

/// A transfer function as equidistant entries, to be interpolated linearly. With nodes at whole HU
/// (up to 16000 apart) there is one entry per HU and the table is exact; otherwise kinks are
/// rounded by one entry, 1/4095 of the range.
struct TransferTable {
  double first_hu;
  double per_hu;             ///< Entries per HU.
  std::vector<float> rgbat;  ///< Four per entry: rgb, extinction per mm.

  [[nodiscard]] int entries() const { return static_cast<int>(rgbat.size() / 4); }
  /// Some value within [low, high] HU, widened by one entry either side, has an extinction > 0.
  [[nodiscard]] bool visible(double low_hu, double high_hu) const;

  explicit TransferTable(const TransferFunction& transfer);

 private:
  std::vector<int> visible_before_;  ///< Number of entries > 0 among the first i.
};

}  // namespace nav::render
