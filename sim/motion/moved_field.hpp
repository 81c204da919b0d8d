// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>

#include "sim/motion/warp.hpp"

namespace nav::sim {

/// Property of moving tissue at a point now: the property at rest of the tissue that is there now.
template <class Field>
auto moved_value(const Warp& warp, const Eigen::Vector3d& now, const Field& at_rest) {
  return at_rest(warp.invert(now));
}

/// Gradient of moved_value() of a scalar, per mm: J^(-T) times the gradient at rest. J is the
/// Jacobian of the warp there.
template <class Gradient>
Eigen::Vector3d moved_gradient(const Warp& warp, const Eigen::Vector3d& now,
                               const Gradient& at_rest) {
  const Eigen::Vector3d rest = warp.invert(now);
  const Eigen::Matrix3d jacobian = warp.jacobian(rest);
  return jacobian.transpose().inverse() * at_rest(rest);
}

}  // namespace nav::sim
