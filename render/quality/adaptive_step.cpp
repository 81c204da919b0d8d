// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/adaptive_step.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "render/parallel.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {
namespace {

constexpr std::size_t kChannels = 4;  // Red, green, blue, extinction per mm.

/// Least and greatest value of each channel; colours only of visible entries.
struct Extremes {
  std::array<float, kChannels> low;
  std::array<float, kChannels> high;
};

constexpr float kFarthest = std::numeric_limits<float>::max();
constexpr Extremes kNone{{kFarthest, kFarthest, kFarthest, kFarthest},
                         {-kFarthest, -kFarthest, -kFarthest, -kFarthest}};

Extremes of_entry(const TransferTable& table, std::size_t i) {
  const float* value = table.rgbat().data() + kChannels * i;
  Extremes e = kNone;
  const bool visible = value[3] > 0;
  for (std::size_t c = visible ? 0 : 3; c < kChannels; ++c) e.low[c] = e.high[c] = value[c];
  return e;
}

Extremes both(const Extremes& a, const Extremes& b) {
  Extremes e;
  for (std::size_t c = 0; c < kChannels; ++c) {
    e.low[c] = std::min(a.low[c], b.low[c]);
    e.high[c] = std::max(a.high[c], b.high[c]);
  }
  return e;
}

double error_per_mm(const Extremes& e, bool shaded) {
  if (!(e.high[3] > 0)) return 0;
  double colour = shaded ? 1 : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    colour = std::max(colour, static_cast<double>(e.high[c]) - e.low[c]);
  }
  return static_cast<double>(e.high[3]) - e.low[3] + e.high[3] * colour;
}

/// First and last entry that a range of values touches, widened by one entry on either side.
struct Entries {
  std::size_t first;
  std::size_t last;
};

Entries entries_in(const TransferTable& table, double low_hu, double high_hu) {
  const double last = table.size() - 1;
  return {
      static_cast<std::size_t>(std::clamp(std::floor(low_hu - table.first_hu()) - 1, 0.0, last)),
      static_cast<std::size_t>(std::clamp(std::ceil(high_hu - table.first_hu()) + 1, 0.0, last))};
}

/// Computes the extremes of 2^level entries from each entry on, level by level.
std::vector<std::vector<Extremes>> levels_of(const TransferTable& table) {
  const auto size = static_cast<std::size_t>(table.size());
  std::vector<std::vector<Extremes>> levels(1);
  for (std::size_t i = 0; i < size; ++i) levels[0].push_back(of_entry(table, i));
  for (std::size_t half = 1; 2 * half <= size; half *= 2) {
    const std::vector<Extremes>& below = levels.back();
    std::vector<Extremes> level;
    level.reserve(size - 2 * half + 1);
    for (std::size_t i = 0; i + 2 * half <= size; ++i) {
      level.push_back(both(below[i], below[i + half]));
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace

std::optional<AdaptiveStep> adaptive_step(const Scene& scene, const TransferTable& table) {
  const Quality& quality = scene.quality;
  const bool applies = quality.adaptive_error > 0 && table.rows() == 1 && !scene.predicates &&
                       quality.classification == Classification::kPreIntegrated &&
                       scene.projection == Projection::kComposite;
  if (!applies) return std::nullopt;
  return AdaptiveStep{quality.adaptive_error, spec::step_mm(quality, scene.ct->grid()),
                      scene.shading.enabled};
}

double segment_error_per_mm(const TransferTable& table, double low_hu, double high_hu,
                            bool shaded) {
  const Entries in = entries_in(table, low_hu, high_hu);
  Extremes e = kNone;
  for (std::size_t i = in.first; i <= in.last; ++i) e = both(e, of_entry(table, i));
  return error_per_mm(e, shaded);
}

std::vector<std::uint8_t> brick_cells(const BrickGrid& bricks, const TransferTable& table,
                                      const AdaptiveStep& adaptive, int threads) {
  const auto levels = levels_of(table);
  std::vector<std::uint8_t> cells(bricks.low.size());
  const int slice = bricks.count.x() * bricks.count.y();
  const double enough = adaptive.error / (adaptive.step_mm * kMostCells);
  for_each_index(bricks.count.z(), threads, [&](int z) {
    const auto end = static_cast<std::size_t>((z + 1) * slice);
    for (auto b = static_cast<std::size_t>(z * slice); b < end; ++b) {
      const Entries in = entries_in(table, bricks.low[b], bricks.high[b]);
      const auto level = static_cast<std::size_t>(std::bit_width(in.last - in.first + 1) - 1);
      const Extremes e =
          both(levels[level][in.first], levels[level][in.last + 1 - (std::size_t{1} << level)]);
      const double per_mm = error_per_mm(e, adaptive.shaded);
      const double most =
          per_mm <= enough ? kMostCells : adaptive.error / (per_mm * adaptive.step_mm);
      cells[b] = static_cast<std::uint8_t>(std::max(1.0, std::floor(most)));
    }
  });
  return cells;
}

}  // namespace nav::render
