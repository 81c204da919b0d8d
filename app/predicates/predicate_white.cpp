// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_white.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <vector>

namespace nav::app {

IntensityWindow intensity_window(std::span<const std::int16_t> voxels,
                                 const std::optional<int>& unknown) {
  constexpr double kBlackShare = 0.01;
  constexpr double kWhiteShare = 0.995;
  constexpr int kDimmestWhite = 128;
  constexpr int kBrightestBlack = 64;
  constexpr int kOffset = -int{std::numeric_limits<std::int16_t>::min()};
  std::vector<std::ptrdiff_t> counts(std::size_t{1} << 16);
  for (const std::int16_t value : voxels) ++counts[static_cast<std::size_t>(value + kOffset)];
  if (unknown && std::abs(*unknown) <= kOffset - 1) {
    counts[static_cast<std::size_t>(*unknown + kOffset)] = 0;
  }
  const auto least = std::ranges::find_if(counts, [](auto count) { return count > 0; });
  if (least == counts.end()) return {};
  *least = 0;
  std::ptrdiff_t known = 0;
  for (const std::ptrdiff_t count : counts) known += count;
  if (known == 0) return {};
  const auto percentile = [&](double share) {
    std::ptrdiff_t below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      below += counts[i];
      if (static_cast<double>(below) >= share * static_cast<double>(known)) {
        return static_cast<int>(i) - kOffset;
      }
    }
    return int{std::numeric_limits<std::int16_t>::max()};
  };
  const int black = percentile(kBlackShare);
  const int white = percentile(kWhiteShare);
  const bool usual =
      white >= kDimmestWhite && white <= 255 && black >= 0 && black <= kBrightestBlack;
  if (usual || white <= black) return {};
  return {static_cast<double>(black), static_cast<double>(white), true};
}

void warn_of_white(const std::string& name, std::span<const std::int16_t> voxels, double white,
                   const std::optional<int>& unknown_voxels, Diagnostics& diagnostics) {
  constexpr double kMostAbove = 0.05;
  constexpr double kLeftAbove = 0.01;
  constexpr int kLeast = std::numeric_limits<std::int16_t>::min();
  constexpr int kGreatest = std::numeric_limits<std::int16_t>::max();
  constexpr int kNone = kGreatest + 1;
  const int unknown = unknown_voxels.value_or(kNone);
  std::ptrdiff_t known = 0;
  std::ptrdiff_t above = 0;
  for (const std::int16_t value : voxels) {
    known += value != unknown ? 1 : 0;
    above += value != unknown && value > white ? 1 : 0;
  }
  if (static_cast<double>(above) <= kMostAbove * static_cast<double>(known)) return;

  std::vector<std::ptrdiff_t> counts(kGreatest - kLeast + 1);
  int greatest = kLeast;
  for (const std::int16_t value : voxels) {
    if (value == unknown) continue;
    ++counts[static_cast<std::size_t>(value - kLeast)];
    greatest = std::max<int>(greatest, value);
  }
  int proposed = greatest;
  for (std::ptrdiff_t left = 0; proposed > kLeast; --proposed) {
    left += counts[static_cast<std::size_t>(proposed - kLeast)];
    if (static_cast<double>(left) > kLeftAbove * static_cast<double>(known)) break;
  }
  std::ostringstream text;
  text << "expected at most 5 % of the known voxels above white (" << white << "), found "
       << std::lround(100.0 * static_cast<double>(above) / static_cast<double>(known))
       << " %, up to " << greatest << ": they all look equal; --white " << proposed
       << " (predicates.white) leaves 1 % above white";
  diagnostics.report(Severity::kWarning, name, text.str());
}

}  // namespace nav::app
