// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace nav {

/// Largest accepted coordinate: 10 km. Anything farther is a mistake of units. Its square is exact.
inline constexpr double kFurthestMm = 1e7;

/// True when no coordinate is NaN or beyond kFurthestMm.
template <int Rows>
bool is_place(const Eigen::Matrix<double, Rows, 1>& mm) {
  return (mm.cwiseAbs().array() <= kFurthestMm).all();
}

}  // namespace nav
