// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "render/transfer_function.hpp"

namespace nav::render {

/// Colour and extinction of a transfer function at equidistant values, to be interpolated linearly
/// in between; the end entries hold outside. Immutable.
class TransferTable {
 public:
  /// Entries at every whole HU from the first node to the last, within the range of int16. Exact
  /// when the nodes lie on whole HU.
  static TransferTable at_whole_hu(const TransferFunction& transfer);
  /// Few enough entries for a texture of any OpenGL 4.1 device: with nodes at whole HU, up to 16000
  /// apart, the same as at_whole_hu() but not cut to int16; otherwise 4096 from the first node to
  /// the last, and kinks are rounded by one entry, 1/4095 of the range.
  static TransferTable for_texture(const TransferFunction& transfer);

  [[nodiscard]] int size() const { return static_cast<int>(rgbat_.size() / 4); }
  [[nodiscard]] double first_hu() const { return first_hu_; }
  [[nodiscard]] double last_hu() const { return first_hu_ + (size() - 1) / per_hu_; }
  /// Entries per HU.
  [[nodiscard]] double per_hu() const { return per_hu_; }
  /// Four per entry: rgb, not premultiplied, and extinction per mm.
  [[nodiscard]] const std::vector<float>& rgbat() const { return rgbat_; }

  /// Some value within [low, high] HU, widened by one entry either side against the rounding of
  /// interpolation, may have an extinction > 0.
  [[nodiscard]] bool visible(double low_hu, double high_hu) const;
  /// Up to here nothing is visible, HU: -infinity when the first entry is, infinity when none is.
  [[nodiscard]] double invisible_up_to_hu() const;

 private:
  TransferTable(const TransferFunction& transfer, double first_hu, double per_hu, int size);

  double first_hu_;
  double per_hu_;
  std::vector<float> rgbat_;
  std::vector<int> visible_before_;  ///< Number of entries > 0 among the first i.
};

/// Whether two functions have the same tables: names and importances may differ.
bool same_tables(const TransferFunction& a, const TransferFunction& b);

}  // namespace nav::render
