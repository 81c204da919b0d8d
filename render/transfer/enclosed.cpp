// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/enclosed.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

/// One slice across an axis, as numbers of voxels.
struct LatticeSlice {
  std::size_t first;   ///< Voxel at its corner.
  std::size_t width;   ///< Number of voxels along u.
  std::size_t height;  ///< Number of voxels along v.
  std::size_t stride_u;
  std::size_t stride_v;
  double pixel_mm2;
};

/// Marks what the mask encloses in a slice.
void mark_enclosed(const LatticeSlice& slice, std::span<const std::uint8_t> mask,
                   std::vector<std::uint8_t>& enclosed) {
  constexpr double kMostMm2 = 2500;
  const std::size_t w = slice.width;
  const std::size_t h = slice.height;
  enum : std::uint8_t { kFree, kWall, kSeen };
  std::vector<std::uint8_t> state(w * h, kFree);
  const auto voxel = [&](std::size_t p) {
    return slice.first + p % w * slice.stride_u + p / w * slice.stride_v;
  };
  bool any = false;
  for (std::size_t p = 0; p < w * h; ++p) {
    if (mask[voxel(p)] == 0) continue;
    any = true;
    // The wall is one pixel wider on each side, which closes gaps.
    state[p] = kWall;
    if (p % w > 0) state[p - 1] = kWall;
    if (p % w + 1 < w) state[p + 1] = kWall;
    if (p >= w) state[p - w] = kWall;
    if (p + w < w * h) state[p + w] = kWall;
  }
  if (!any) return;
  std::vector<std::size_t> region;
  for (std::size_t start = 0; start < w * h; ++start) {
    if (state[start] != kFree) continue;
    region.assign(1, start);
    state[start] = kSeen;
    bool open = false;
    for (std::size_t next = 0; next < region.size(); ++next) {
      const std::size_t p = region[next];
      const std::size_t x = p % w;
      const auto visit = [&](std::size_t n) {
        if (state[n] != kFree) return;
        state[n] = kSeen;
        region.push_back(n);
      };
      open = open || x == 0 || x + 1 == w || p < w || p + w >= w * h;
      if (x > 0) visit(p - 1);
      if (x + 1 < w) visit(p + 1);
      if (p >= w) visit(p - w);
      if (p + w < w * h) visit(p + w);
    }
    if (open || static_cast<double>(region.size()) * slice.pixel_mm2 > kMostMm2) continue;
    for (const std::size_t p : region) {
      enclosed[voxel(p)] = 1;
      // The inner half of the wider wall.
      const auto inner = [&](std::size_t n) {
        if (mask[voxel(n)] == 0) enclosed[voxel(n)] = 1;
      };
      const std::size_t x = p % w;
      if (x > 0) inner(p - 1);
      if (x + 1 < w) inner(p + 1);
      if (p >= w) inner(p - w);
      if (p + w < w * h) inner(p + w);
    }
  }
}

}  // namespace

std::vector<std::uint8_t> homogeneous_voxels(const VoxelLattice& lattice,
                                             std::span<const std::int16_t> hu) {
  constexpr int kMostHu = 60;
  std::vector<std::uint8_t> homogeneous(lattice.count(), 1);
  const std::size_t width = lattice.size(0);
  const auto height = static_cast<int>(lattice.size(1));
  const auto depth = static_cast<int>(lattice.size(2));
  for_each_index(depth, 0, [&](int z) {
    for (int y = 0; y < height; ++y) {
      const std::size_t first = static_cast<std::size_t>(z) * lattice.stride(2) +
                                static_cast<std::size_t>(y) * lattice.stride(1);
      const std::int16_t* at = hu.data() + first;
      std::uint8_t* same = homogeneous.data() + first;
      const auto compare = [&](std::size_t begin, std::size_t end, const std::int16_t* other) {
        for (std::size_t x = begin; x < end; ++x) {
          same[x] &= static_cast<std::uint8_t>(std::abs(at[x] - other[x]) <= kMostHu);
        }
      };
      compare(1, width, at - 1);
      compare(0, width - 1, at + 1);
      if (y > 0) compare(0, width, at - lattice.stride(1));
      if (y + 1 < height) compare(0, width, at + lattice.stride(1));
      if (z > 0) compare(0, width, at - lattice.stride(2));
      if (z + 1 < depth) compare(0, width, at + lattice.stride(2));
    }
  });
  return homogeneous;
}

std::vector<std::uint8_t> enclosed_voxels(const VoxelLattice& lattice,
                                          std::span<const std::uint8_t> mask) {
  std::vector<std::uint8_t> enclosed(lattice.count(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    const int u = axis == 0 ? 1 : 0;
    const int v = axis == 2 ? 1 : 2;
    // Slices of one orientation have no voxel in common.
    for_each_index(static_cast<int>(lattice.size(axis)), 0, [&](int n) {
      mark_enclosed(
          {static_cast<std::size_t>(n) * lattice.stride(axis), lattice.size(u), lattice.size(v),
           lattice.stride(u), lattice.stride(v), lattice.spacing_mm(u) * lattice.spacing_mm(v)},
          mask, enclosed);
    });
  }
  return enclosed;
}

std::vector<std::uint8_t> within_voxels(const VoxelLattice& lattice, std::vector<std::uint8_t> mask,
                                        int voxels) {
  const std::size_t width = lattice.size(0);
  const auto height = static_cast<int>(lattice.size(1));
  const auto depth = static_cast<int>(lattice.size(2));
  std::vector<std::uint8_t> wider(mask.size());
  for (int step = 0; step < voxels; ++step) {
    for_each_index(depth, 0, [&](int z) {
      for (int y = 0; y < height; ++y) {
        const std::size_t first = static_cast<std::size_t>(z) * lattice.stride(2) +
                                  static_cast<std::size_t>(y) * lattice.stride(1);
        const std::uint8_t* at = mask.data() + first;
        std::uint8_t* to = wider.data() + first;
        const auto add = [&](std::size_t begin, std::size_t end, const std::uint8_t* other) {
          for (std::size_t x = begin; x < end; ++x) to[x] |= other[x];
        };
        std::copy_n(at, width, to);
        add(1, width, at - 1);
        add(0, width - 1, at + 1);
        if (y > 0) add(0, width, at - lattice.stride(1));
        if (y + 1 < height) add(0, width, at + lattice.stride(1));
        if (z > 0) add(0, width, at - lattice.stride(2));
        if (z + 1 < depth) add(0, width, at + lattice.stride(2));
      }
    });
    std::swap(mask, wider);
  }
  return mask;
}

std::vector<std::vector<std::uint32_t>> components_of(const VoxelLattice& lattice,
                                                      std::span<const std::uint8_t> mask) {
  std::vector<std::uint8_t> seen(mask.size(), 0);
  std::vector<std::vector<std::uint32_t>> parts;
  for (std::size_t start = 0; start < mask.size(); ++start) {
    if (mask[start] == 0 || seen[start] != 0) continue;
    std::vector<std::uint32_t> part{static_cast<std::uint32_t>(start)};
    seen[start] = 1;
    for (std::size_t next = 0; next < part.size(); ++next) {
      lattice.for_each_neighbour(part[next], [&](std::size_t n) {
        if (mask[n] == 0 || seen[n] != 0) return;
        seen[n] = 1;
        part.push_back(static_cast<std::uint32_t>(n));
      });
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace nav::render
