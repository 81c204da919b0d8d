// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <random>

namespace nav::test {

/// Normally distributed vectors that are equal with every standard library.
class Normal {
 public:
  explicit Normal(unsigned seed) : random_(seed) {}
  /// Returns a vector with variance 1 along each axis.
  Eigen::Vector3d vector() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }
  Eigen::Vector3d vector(const Eigen::Matrix3d& covariance) {
    return covariance.llt().matrixL() * vector();
  }

 private:
  double uniform() { return (static_cast<double>(random_()) + 0.5) / 4294967296.0; }
  double next() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * M_PI * uniform());
  }
  std::mt19937 random_;
};

}  // namespace nav::test
