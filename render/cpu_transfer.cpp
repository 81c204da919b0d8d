// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_transfer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nav::render {
namespace {

constexpr double kMinHu = -32768;
constexpr double kMaxHu = 32767;
constexpr std::size_t kTail = 3;  // A byte is fetched as the first of four.

/// Distances after one sweep: from the neighbours already visited when walking in direction
/// step (+1 or -1) through the bricks.
void sweep(const std::array<int, 3>& n, int step, std::vector<std::uint8_t>& d) {
  const int total = n[0] * n[1] * n[2];
  const auto inside = [&](int x, int y, int z) {
    return x >= 0 && x < n[0] && y >= 0 && y < n[1] && z >= 0 && z < n[2];
  };
  for (int count = 0, at = step > 0 ? 0 : total - 1; count < total; ++count, at += step) {
    const int x = at % n[0];
    const int y = at / n[0] % n[1];
    const int z = at / (n[0] * n[1]);
    int best = d[static_cast<std::size_t>(at)];
    // The 13 neighbours that precede in this direction; the order of the others mirrors them.
    for (int i = 0; i < 13 && best > 0; ++i) {
      const int dx = (i % 3 - 1) * step;
      const int dy = (i / 3 % 3 - 1) * step;
      const int dz = (i / 9 - 1) * step;
      if (!inside(x + dx, y + dy, z + dz)) continue;
      const int neighbour = at + dx + n[0] * (dy + n[1] * dz);
      best = std::min(best, d[static_cast<std::size_t>(neighbour)] + 1);
    }
    d[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(best);
  }
}

}  // namespace

CpuTransfer::CpuTransfer(const TransferFunction& transfer) {
  low_ = static_cast<int>(std::clamp(std::floor(transfer.nodes().front().hu), kMinHu, kMaxHu - 1));
  high_ = static_cast<int>(std::clamp(std::ceil(transfer.nodes().back().hu), low_ + 1.0, kMaxHu));
  const auto size = static_cast<std::size_t>(high_ - low_ + 1);
  entries_.resize(size);
  visible_before_.assign(size + 1, 0);
  for (std::size_t i = 0; i < size; ++i) {
    const TransferSample s = transfer.at(low_ + static_cast<double>(i));
    const float value[4] = {static_cast<float>(s.rgb.x()), static_cast<float>(s.rgb.y()),
                            static_cast<float>(s.rgb.z()), static_cast<float>(s.tau_per_mm)};
    std::copy_n(value, 4, entries_[i].value);
    visible_before_[i + 1] = visible_before_[i] + (value[3] > 0 ? 1 : 0);
    if (i == 0) continue;
    for (std::size_t c = 0; c < 4; ++c)
      entries_[i - 1].to_next[c] = value[c] - entries_[i - 1].value[c];
  }
  std::fill_n(entries_.back().to_next, 4, 0.0F);
}

float CpuTransfer::invisible_up_to_hu() const {
  // visible_before_[i + 1] > 0 first where entry i is visible; the one before is the last clear.
  const auto visible = std::upper_bound(visible_before_.begin(), visible_before_.end(), 0);
  if (visible == visible_before_.end()) return std::numeric_limits<float>::infinity();
  const auto clear = visible - visible_before_.begin() - 2;
  if (clear < 0) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(low_ + static_cast<int>(clear));
}

bool CpuTransfer::invisible(int min_hu, int max_hu) const {
  // One HU of margin covers the rounding of interpolation, which may leave the range by an ulp.
  const int first = std::clamp(min_hu - 1, low_, high_) - low_;
  const int last = std::clamp(max_hu + 1, low_, high_) - low_;
  return visible_before_[static_cast<std::size_t>(last) + 1] ==
         visible_before_[static_cast<std::size_t>(first)];
}

BrickDistances brick_distances(const CpuVolume& volume, const CpuTransfer& transfer) {
  BrickDistances out;
  out.distance.resize(static_cast<std::size_t>(volume.brick_count()));
  for (int brick = 0; brick < volume.brick_count(); ++brick) {
    const bool empty = transfer.invisible(volume.brick_min(brick), volume.brick_max(brick));
    out.distance[static_cast<std::size_t>(brick)] = empty ? 255 : 0;
    if (!empty) ++out.occupied;
  }
  // Two sweeps over the 26-neighbourhood give the exact chessboard distance.
  sweep(volume.bricks(), +1, out.distance);
  sweep(volume.bricks(), -1, out.distance);
  out.distance.resize(out.distance.size() + kTail, 255);
  return out;
}

}  // namespace nav::render
