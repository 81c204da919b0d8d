// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "render/scene.hpp"

namespace nav::bench {

/// Bricks of one size, and what leaping over those that show nothing would leave.
struct BrickOracle {
  int edge = 0;               ///< Voxels.
  double occupied = 0;        ///< Share of bricks whose range of values may show something.
  std::uint64_t samples = 0;  ///< Of rays that look at every brick that they enter.
};

/// What a march of a composited CT, pre-integrated, could spare at best. Numbers of samples; a cell
/// takes the two at its ends, neighbours share theirs.
struct SkipOracle {
  std::uint64_t all = 0;      ///< Of whole rays.
  std::uint64_t opaque = 0;   ///< Of these, behind the cell in which its ray becomes opaque.
  std::uint64_t showing = 0;  ///< Of cells in front of that whose opacity is above zero.
  std::array<BrickOracle, 4> bricks{{{8}, {4}, {2}, {1}}};
};
/// By a march in double precision. Plane, needle and cutaway are left out. threads: 0: all cores.
SkipOracle skip_oracle(const render::Scene& scene, int threads = 0);

}  // namespace nav::bench
