// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_lattice.hpp"

#include <Eigen/Core>
#include <bit>

namespace nav::render {
namespace {

/// Values by which rays are compared: the colour around the ultrasound image, and the weight of
/// that image.
Eigen::Array4f colour_of(const PixelRecord& record) {
  static_assert(offsetof(PixelRecord, weight) == 3 * sizeof(float));
  return Eigen::Map<const Eigen::Array4f>(record.base);
}

/// Position in the ultrasound image that a record shows.
Eigen::Array2f position_of(const PixelRecord& record) { return {record.column, record.row}; }

/// Mean of the values that get() returns for the corners. Pairs are added first, so that the mean
/// does not depend on a direction.
template <std::size_t kCorners, class Get>
auto mean_of(const std::array<const PixelRecord*, kCorners>& corners, const Get& get) {
  decltype(get(*corners[0])) sum = get(*corners[0]) + get(*corners[1]);
  if constexpr (kCorners == 4) {
    const decltype(sum) more = get(*corners[2]) + get(*corners[3]);
    sum += more;
  }
  sum *= 1.0F / kCorners;
  return sum;
}

template <std::size_t kCorners>
PixelRecord mean_record(const std::array<const PixelRecord*, kCorners>& corners) {
  PixelRecord mean;
  Eigen::Map<Eigen::Array4f>(mean.base) = mean_of(corners, colour_of);
  const bool seen = mean.weight > 0;
  const Eigen::Array2f place =
      seen ? Eigen::Array2f(mean_of(corners, position_of)) : Eigen::Array2f::Zero();
  mean.column = place.x();
  mean.row = place.y();
  mean.signature = 0;  // No ray has this signature, so a ray is cast if one is needed.
  return mean;
}

}  // namespace

bool LatticeSquares::find_one(int x, int y) const {
  const int right = x + side();
  const int below = y + side();
  if (x < 0 || y < 0 || lattice_.beyond(right, below)) return false;
  const Eigen::Array4f a = colour_of(image_.at(x, y));
  const Eigen::Array4f b = colour_of(image_.at(right, y));
  const Eigen::Array4f c = colour_of(image_.at(x, below));
  const Eigen::Array4f d = colour_of(image_.at(right, below));
  const Eigen::Array4f low = a.min(b).min(c.min(d));
  const Eigen::Array4f high = a.max(b).max(c.max(d));
  return ((high - low) <= error_).all() && (low.w() > 0) == (high.w() > 0);
}

void LatticeSquares::find(int x0, int y0, int side) {
  shift_ = std::countr_zero(static_cast<unsigned>(side));
  x0_ = x0 - side;
  y0_ = y0 - side;
  const int count = kTile / side + 1;
  for (int row = 0; row < count; ++row) {
    for (int column = 0; column < count; ++column) {
      even_[static_cast<std::size_t>(row * kMost + column)] =
          find_one(x0_ + column * side, y0_ + row * side);
    }
  }
}

bool LatticeSquares::even_around(int x, int y) const {
  const int column0 = x0_ >> shift_;
  const int row0 = y0_ >> shift_;
  return lattice_.even_around(
      x, y, shift_, [&](int column, int row) { return at(column - column0, row - row0); });
}

void LatticeSquares::fill(int x, int y) const {
  const int across = beyond_edge(x);
  const int down = beyond_edge(y);
  PixelRecord& pixel = image_.at(x, y);
  if (across == 0 || down == 0) {
    pixel = mean_record<2>({&image_.at(x - across, y - down), &image_.at(x + across, y + down)});
  } else {
    pixel = mean_record<4>({&image_.at(x - across, y - down), &image_.at(x + across, y + down),
                            &image_.at(x - across, y + down), &image_.at(x + across, y - down)});
  }
}

}  // namespace nav::render
