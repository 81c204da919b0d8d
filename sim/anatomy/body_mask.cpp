// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/body_mask.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace nav::sim {
namespace {

constexpr int kSureAirBelowHu = -920;  // Lung that is cut open by the border of a CT is above.
constexpr int kAirBelowHu = -400;
constexpr int kRimVoxels = 2;  // Width of the blurred skin between the two.

struct Grid3 {
  std::array<int, 3> size;
  [[nodiscard]] std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool holds(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
};

/// Grows the outside by one voxel into voxels that are less than half tissue.
void grow(const Volume& ct, const Grid3& grid, std::vector<std::uint8_t>& outside) {
  const std::vector<std::uint8_t> before = outside;
  const auto was = [&](int i, int j, int k) {
    return grid.holds(i, j, k) && before[grid.at(i, j, k)] != 0;
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t v = grid.at(i, j, k);
        if (before[v] != 0 || ct.hu()[v] >= kAirBelowHu) continue;
        for (const int d : {-1, 1}) {
          if (was(i + d, j, k) || was(i, j + d, k) || was(i, j, k + d)) outside[v] = 1;
        }
      }
    }
  }
}

/// 1 where air is connected to a side face. The faces along k do not count: the airway is open
/// there.
std::vector<std::uint8_t> outside_air(const Volume& ct) {
  const Grid3 grid{ct.grid().size};
  std::vector<std::uint8_t> outside(ct.hu().size(), 0);
  std::vector<std::array<int, 3>> front;
  const auto visit = [&](int i, int j, int k) {
    if (!grid.holds(i, j, k)) return;
    const std::size_t v = grid.at(i, j, k);
    if (outside[v] != 0 || ct.hu()[v] >= kSureAirBelowHu) return;
    outside[v] = 1;
    front.push_back({i, j, k});
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) visit(0, j, k), visit(grid.size[0] - 1, j, k);
    for (int i = 0; i < grid.size[0]; ++i) visit(i, 0, k), visit(i, grid.size[1] - 1, k);
  }
  while (!front.empty()) {
    const auto [i, j, k] = front.back();
    front.pop_back();
    for (const int d : {-1, 1}) visit(i + d, j, k), visit(i, j + d, k), visit(i, j, k + d);
  }
  for (int n = 0; n < kRimVoxels; ++n) grow(ct, grid, outside);
  return outside;
}

/// Distance to the voxels where \p from is \p set, by two chamfer passes over the 26 neighbours.
std::vector<float> chamfer(const Volume& ct, const std::vector<std::uint8_t>& from, bool set) {
  const Grid3 grid{ct.grid().size};
  constexpr float kFar = 1e9F;
  std::vector<float> d(from.size());
  for (std::size_t v = 0; v < d.size(); ++v) d[v] = (from[v] != 0) == set ? 0.0F : kFar;
  struct Step {
    int i, j, k;
    float mm;
  };
  std::vector<Step> before;
  for (int n = 0; n < 13; ++n) {  // The neighbours that are earlier in memory.
    const Step s{n % 3 - 1, (n / 3) % 3 - 1, n / 9 - 1, 0};
    const Eigen::Vector3d way = ct.grid().spacing_mm.cwiseProduct(Eigen::Vector3d(s.i, s.j, s.k));
    before.push_back({s.i, s.j, s.k, static_cast<float>(way.norm())});
  }
  const auto relax = [&](int i, int j, int k, int sign) {
    float& own = d[grid.at(i, j, k)];
    for (const Step& s : before) {
      const int a = i + sign * s.i, b = j + sign * s.j, c = k + sign * s.k;
      if (grid.holds(a, b, c)) own = std::min(own, d[grid.at(a, b, c)] + s.mm);
    }
  };
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) relax(i, j, k, 1);
  for (int k = grid.size[2]; k-- > 0;)
    for (int j = grid.size[1]; j-- > 0;)
      for (int i = grid.size[0]; i-- > 0;) relax(i, j, k, -1);
  return d;
}

}  // namespace

Result<std::vector<float>> skin_distance_of(const Volume& ct) {
  const std::vector<std::uint8_t> outside = outside_air(ct);
  const auto body = std::ranges::count(outside, std::uint8_t{0});
  if (body == 0) {
    return Error{ErrorCode::kMalformedData,
                 "patient of a CT: expected a body in '" + ct.name() + "', found only air"};
  }
  const auto half = static_cast<float>(0.5 * ct.grid().spacing_mm.minCoeff());
  const std::vector<float> from_body = chamfer(ct, outside, false);
  std::vector<float> distance = chamfer(ct, outside, true);
  for (std::size_t v = 0; v < distance.size(); ++v) {
    // The surface is midway between the centres of the last voxel inside and the first outside.
    distance[v] = outside[v] != 0 ? from_body[v] - half : half - std::min(distance[v], 1e6F);
  }
  return distance;
}

}  // namespace nav::sim
