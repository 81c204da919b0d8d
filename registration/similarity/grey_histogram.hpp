// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace nav::registration {

/// Number of cells of each grey, in two parts: neighbours, mostly of similar grey, need not wait
/// for each other. A negative grey means that the cell has no pixel.
class GreyHistogram {
 public:
  void add(std::span<const float> greys) {
    int* even = bins_[0].data();
    int* odd = bins_[1].data();
    std::size_t i = 0;
    for (; i + 1 < greys.size(); i += 2) {
      ++even[bin_of(greys[i])];
      ++odd[bin_of(greys[i + 1])];
    }
    if (i < greys.size()) ++even[bin_of(greys[i])];
  }
  /// The least grey, 0 to 255, that a share of the cells, in [0, 1], does not exceed; absent
  /// without cells.
  [[nodiscard]] std::optional<int> quantile(double share) const {
    const auto count = [&](std::size_t bin) { return bins_[0][bin] + bins_[1][bin]; };
    std::int64_t total = 0;
    for (std::size_t bin = 1; bin < kBins; ++bin) total += count(bin);
    if (total == 0) return std::nullopt;
    const double wanted = share * static_cast<double>(total);
    std::int64_t seen = 0;
    std::size_t bin = 1;
    while (bin + 1 < kBins && static_cast<double>(seen += count(bin)) < wanted) ++bin;
    return static_cast<int>(bin) - 1;
  }

 private:
  static constexpr std::size_t kBins = 257;  // Cells without a pixel come first.
  static int bin_of(float grey) { return static_cast<int>(std::min(grey, 255.0f)) + 1; }
  std::array<std::array<int, kBins>, 2> bins_{};
};

/// The greys of all lines of one depth in all images. greys: depth * lines + line.
inline GreyHistogram greys_at(const std::vector<std::vector<float>>& greys, std::size_t depth,
                              std::size_t lines) {
  GreyHistogram histogram;
  for (const auto& image : greys) histogram.add(std::span(image).subspan(depth * lines, lines));
  return histogram;
}

}  // namespace nav::registration
