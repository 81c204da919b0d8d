// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/starts.hpp"

#include <array>
#include <cmath>

#include "registration/counter_random.hpp"

namespace nav::registration {
namespace {

double radical_inverse(int index, int base) {
  double result = 0;
  double digit = 1.0 / base;
  for (; index > 0; index /= base, digit /= base) result += digit * (index % base);
  return result;
}

}  // namespace

std::vector<Vector6d> spread_twists(int count, double range_rad, double range_mm,
                                    std::uint64_t seed) {
  constexpr std::array<int, 6> kBases{2, 3, 5, 7, 11, 13};
  std::vector<Vector6d> twists;
  twists.reserve(static_cast<std::size_t>(count));
  for (int i = 1; i <= count; ++i) {
    Vector6d twist;
    for (std::size_t axis = 0; axis < kBases.size(); ++axis) {
      const double shifted = radical_inverse(i, kBases[axis]) + fraction(seed * 6 + axis);
      const double range = axis < 3 ? range_rad : range_mm;
      twist[static_cast<Eigen::Index>(axis)] = range * (2 * (shifted - std::floor(shifted)) - 1);
    }
    twists.push_back(twist);
  }
  return twists;
}

}  // namespace nav::registration
