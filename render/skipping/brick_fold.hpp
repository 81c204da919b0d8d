// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

#include "render/parallel.hpp"

namespace nav::render {

/// A fold over the voxels of each brick: join(join(neutral, voxel), …). Joined values are joined
/// again, so join must be associative and commutative on them.
template <class T, class Join>
struct BrickFold {
  T neutral;
  Join join;
  std::vector<T>& bricks;  ///< x fastest; resized.
};
template <class T, class Join>
BrickFold(T, Join, std::vector<T>&) -> BrickFold<T, Join>;

/// Folds over bricks of \p edge voxels a side and the first voxels of their neighbours; the last
/// brick of an axis has the remaining voxels. One pass over the voxels, i fastest. threads 0: all
/// cores. Returns the number of bricks along each axis.
template <class Voxel, class... Folds>
Eigen::Vector3i fold_bricks(const Voxel* voxels, const std::array<int, 3>& size, int edge,
                            int threads, const Folds&... folds) {
  const auto size_of = [](int n) { return static_cast<std::size_t>(n); };
  const auto count = [&](std::size_t axis) { return (size[axis] - 1) / edge + 1; };
  const auto end = [&](int brick, std::size_t axis) {
    return std::min((brick + 1) * edge + 1, size[axis]);
  };
  const std::size_t width = size_of(size[0]);
  (folds.bricks.resize(size_of(count(0)) * size_of(count(1)) * size_of(count(2))), ...);
  for_each_index(count(2), threads, [&](int bz) {
    // First folds each column of voxels through a row of bricks: the compiler turns long rows into
    // vector instructions, but not short ones.
    auto columns = std::tuple(std::vector(width, folds.neutral)...);
    const auto for_each_fold = [&](const auto& visit) {
      std::apply([&](auto&... column) { (visit(folds, column), ...); }, columns);
    };
    for (int by = 0; by < count(1); ++by) {
      for_each_fold([](const auto& fold, auto& column) {
        std::fill(column.begin(), column.end(), fold.neutral);
      });
      for (int k = bz * edge; k < end(bz, 2); ++k) {
        for (int j = by * edge; j < end(by, 1); ++j) {
          const Voxel* row = voxels + (size_of(k) * size_of(size[1]) + size_of(j)) * width;
          for_each_fold([&](const auto& fold, auto& column) {
            auto* joined = column.data();
            for (std::size_t i = 0; i < width; ++i) joined[i] = fold.join(joined[i], row[i]);
          });
        }
      }
      for_each_fold([&](const auto& fold, const auto& column) {
        for (int bx = 0; bx < count(0); ++bx) {
          auto joined = fold.neutral;
          for (int i = bx * edge; i < end(bx, 0); ++i) {
            joined = fold.join(joined, column[size_of(i)]);
          }
          fold.bricks[size_of((bz * count(1) + by) * count(0) + bx)] = joined;
        }
      });
    }
  });
  return {count(0), count(1), count(2)};
}

inline constexpr auto kLeast = [](auto a, auto b) { return std::min(a, b); };
inline constexpr auto kGreatest = [](auto a, auto b) { return std::max(a, b); };

}  // namespace nav::render
