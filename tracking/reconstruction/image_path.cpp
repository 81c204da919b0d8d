// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/image_path.hpp"

#include <algorithm>
#include <cmath>

namespace nav::tracking {
namespace {

std::int64_t fixed(double voxels) { return std::llround(std::ldexp(voxels, kPositionBits)); }

/// a / b rounded down; b > 0.
std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }
std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return a / b + (a % b > 0 ? 1 : 0); }

}  // namespace

std::optional<ImagePath> ImagePath::of(const TrackedImage& image,
                                       const VoxelGridIn<frames::Reference>& grid, double shift) {
  const auto index = [&](double column, double row) -> Eigen::Vector3d {
    return grid.index_of(image.reference_from_image * image.frame.grid.at(column, row)) +
           Eigen::Vector3d::Constant(shift);
  };
  ImagePath path;
  path.start_ = index(0, 0);
  path.per_column_ = index(1, 0) - path.start_;
  path.per_row_ = index(0, 1) - path.start_;
  constexpr double kFurthest = 1 << 29;
  const double last_column = image.frame.pixels.width() - 1;
  const double last_row = image.frame.pixels.height() - 1;
  for (const auto& corner : {path.at(0, 0), path.at(last_column, 0), path.at(0, last_row),
                             path.at(last_column, last_row)}) {
    if (!(corner.cwiseAbs().maxCoeff() < kFurthest)) return std::nullopt;
  }
  for (int axis = 0; axis < 3; ++axis)
    path.step_[static_cast<std::size_t>(axis)] = fixed(path.per_column_[axis]);
  return path;
}

FixedPosition ImagePath::row_start(int row) const {
  const Eigen::Vector3d start = at(0, row);
  return {fixed(start.x()), fixed(start.y()), fixed(start.z())};
}

ColumnSpan columns_within(ColumnSpan columns, std::int64_t start, std::int64_t step,
                          std::int64_t low, std::int64_t high) {
  std::int64_t first = columns.first;
  std::int64_t past = columns.past;
  if (step == 0) {
    if (start < low || start >= high) past = first;
  } else if (step > 0) {
    first = std::max(first, ceil_div(low - start, step));
    past = std::min(past, ceil_div(high - start, step));
  } else {
    first = std::max(first, floor_div(start - high, -step) + 1);
    past = std::min(past, floor_div(start - low, -step) + 1);
  }
  if (first >= past) return {0, 0};
  return {static_cast<int>(first), static_cast<int>(past)};
}

}  // namespace nav::tracking
