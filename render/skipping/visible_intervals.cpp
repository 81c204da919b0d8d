// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/visible_intervals.hpp"

#include <algorithm>
#include <limits>

#include "nav/index.hpp"

namespace nav::render {
namespace {

constexpr int kLeastVoxel = std::numeric_limits<std::int16_t>::min();
constexpr int kGreatestVoxel = std::numeric_limits<std::int16_t>::max();

std::int16_t clamped_voxel(int hu) {
  return static_cast<std::int16_t>(std::clamp(hu, kLeastVoxel, kGreatestVoxel));
}

}  // namespace

std::vector<VisibleInterval> visible_intervals(const TransferTable& table) {
  std::vector<VisibleInterval> out;
  const std::vector<int>& before = table.visible_before();
  const int first_hu = static_cast<int>(table.first_hu());
  const auto visible = [&](int entry) {
    return before[as_size(entry) + 1] > before[as_size(entry)];
  };
  for (int first = 0; first < table.size(); ++first) {
    if (!visible(first)) continue;
    int last = first;
    while (last + 1 < table.size() && visible(last + 1)) ++last;
    // The end values hold outside the table.
    out.push_back({clamped_voxel(first == 0 ? kLeastVoxel : first + first_hu - 1),
                   clamped_voxel(last == table.size() - 1 ? kGreatestVoxel : last + first_hu + 1)});
    first = last;
  }
  return out;
}

}  // namespace nav::render
