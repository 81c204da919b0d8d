// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/body.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "nav/check.hpp"
#include "render/parallel.hpp"
#include "render/transfer/enclosed.hpp"

namespace nav::render {
namespace {

constexpr int kBodyHu = -300;
constexpr int kEmptyHu = -900;  // Air with noise.
constexpr double kErosionMm = 4;

using BodyMask = std::vector<std::uint8_t>;

/// Number of voxels that a distance in mm has along the axis with the smallest spacing, at least 1.
int steps_of(const VoxelGrid& grid, double mm) {
  return std::max(1, static_cast<int>(std::lround(mm / grid.spacing_mm.minCoeff())));
}

/// A mask without the voxels within some steps of its outside. Beyond the volume it continues.
BodyMask eroded(const VoxelLattice& lattice, BodyMask mask, int steps) {
  for (std::uint8_t& one : mask) one ^= 1U;
  mask = within_voxels(lattice, std::move(mask), steps);
  for (std::uint8_t& one : mask) one ^= 1U;
  return mask;
}

/// Largest component; the first of equals. Empty if there is none.
std::vector<std::uint32_t> largest_component(const VoxelLattice& lattice, const BodyMask& mask) {
  auto parts = components_of(lattice, mask);
  const auto most = std::ranges::max_element(parts, {}, &std::vector<std::uint32_t>::size);
  return most == parts.end() ? std::vector<std::uint32_t>{} : std::move(*most);
}

/// True when a mask covers more than half of the border of an axial slice.
bool covers_border(const VoxelLattice& lattice, const BodyMask& mask, std::size_t slice) {
  const std::size_t w = lattice.size(0);
  const std::size_t h = lattice.size(1);
  const std::size_t first = slice * lattice.stride(2);
  std::size_t border = 0;
  std::size_t covered = 0;
  for (std::size_t p = 0; p < w * h; ++p) {
    const std::size_t x = p % w;
    if (x > 0 && x + 1 < w && p >= w && p + w < w * h) continue;
    ++border;
    covered += mask[first + p];
  }
  return 2 * covered > border;
}

/// Marks what cannot be reached in an axial slice from its border without crossing the mask.
void fill_slice(const VoxelLattice& lattice, BodyMask& mask, std::size_t slice) {
  const std::size_t w = lattice.size(0);
  const std::size_t h = lattice.size(1);
  std::uint8_t* at = mask.data() + slice * lattice.stride(2);
  std::vector<std::uint8_t> outside(w * h, 0);
  std::vector<std::size_t> front;
  const auto visit = [&](std::size_t p) {
    if (at[p] != 0 || outside[p] != 0) return;
    outside[p] = 1;
    front.push_back(p);
  };
  for (std::size_t x = 0; x < w; ++x) {
    visit(x);
    visit((h - 1) * w + x);
  }
  for (std::size_t y = 0; y < h; ++y) {
    visit(y * w);
    visit(y * w + w - 1);
  }
  while (!front.empty()) {
    const std::size_t p = front.back();
    front.pop_back();
    const std::size_t x = p % w;
    if (x > 0) visit(p - 1);
    if (x + 1 < w) visit(p + 1);
    if (p >= w) visit(p - w);
    if (p + w < w * h) visit(p + w);
  }
  for (std::size_t p = 0; p < w * h; ++p) at[p] = static_cast<std::uint8_t>(outside[p] == 0);
}

}  // namespace

BodyOnly without_table(const std::shared_ptr<const Volume>& ct) {
  const VoxelLattice lattice(ct->grid());
  const auto hu = ct->hu();
  BodyMask mask(hu.size());
  std::ranges::transform(hu, mask.begin(),
                         [](int v) { return static_cast<std::uint8_t>(v >= kBodyHu); });
  const int steps = steps_of(ct->grid(), kErosionMm);
  const auto core = largest_component(lattice, eroded(lattice, std::move(mask), steps));
  if (core.empty()) return {ct};
  mask.assign(hu.size(), 0);
  for (const std::uint32_t i : core) mask[i] = 1;
  mask = within_voxels(lattice, std::move(mask), 2 * steps);
  for_each_index(static_cast<int>(lattice.size(2)), 0, [&](int slice) {
    const auto k = static_cast<std::size_t>(slice);
    if (covers_border(lattice, mask, k)) {
      std::fill_n(mask.data() + k * lattice.stride(2), lattice.stride(2), std::uint8_t{1});
    } else {
      fill_slice(lattice, mask, k);
    }
  });
  std::vector<std::int16_t> kept(hu.begin(), hu.end());
  std::size_t removed = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (mask[i] != 0 || kept[i] <= kEmptyHu) continue;
    kept[i] = kAirHu;
    ++removed;
  }
  if (removed == 0) return {ct};
  auto made = Volume::create(ct->grid(), std::move(kept), ct->name());
  NAV_CHECK(made.has_value());
  return {std::make_shared<const Volume>(*std::move(made)),
          static_cast<double>(removed) * ct->grid().spacing_mm.prod() / 1000};
}

}  // namespace nav::render
