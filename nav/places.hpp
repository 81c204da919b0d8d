// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace nav {

/// 10 km: farther is a mistake of units. Squares of it stay exact.
inline constexpr double kFurthestMm = 1e7;

/// Whether no coordinate is NaN or beyond kFurthestMm.
template <int Rows>
bool is_place(const Eigen::Matrix<double, Rows, 1>& mm) {
  return (mm.cwiseAbs().array() <= kFurthestMm).all();
}

}  // namespace nav
