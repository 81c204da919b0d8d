// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "render/scene.hpp"

namespace nav::bench {

/// Bricks of one size, and the samples that remain if bricks that show nothing are skipped.
struct BrickOracle {
  int edge = 0;               ///< Voxels.
  double occupied = 0;        ///< Fraction of bricks whose range of values may show something.
  std::uint64_t samples = 0;  ///< Samples of rays that test every brick that they enter.
};

/// Best possible saving in ray casting of a composited, pre-integrated CT, in numbers of samples. A
/// cell takes the two samples at its ends; neighbours share theirs.
struct SkipOracle {
  std::uint64_t all = 0;      ///< Samples of whole rays.
  std::uint64_t opaque = 0;   ///< Samples of these behind the cell in which the ray becomes opaque.
  std::uint64_t showing = 0;  ///< Samples of cells in front of that cell with opacity above zero.
  std::array<BrickOracle, 4> bricks{{{8}, {4}, {2}, {1}}};
};
/// Marches in double precision. Plane, needle and cutaway are left out. threads: 0: all cores.
SkipOracle skip_oracle(const render::Scene& scene, int threads = 0);

}  // namespace nav::bench
