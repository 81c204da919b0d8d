// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "nav/matrices.hpp"

namespace nav::registration {

/// Corrects the Gauss–Newton Hessian, which takes the fit of a patch to its noise for curvature: it
/// is up to ten times stiffer than the cost, and steps are too short by the same factor. The change
/// of the exact gradient over the last step shows the excess (structured BFGS: Dennis, Martinez and
/// Tapia 1989). N parameters, or Eigen::Dynamic.
template <int N>
class SecantCurvature {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// The Gauss–Newton Hessian, corrected by the steps so far; positive definite if the Gauss–Newton
  /// Hessian is.
  Matrix corrected(const Vector& delta, const Vector& gradient, const Matrix& stiff) {
    Matrix b = stiff;
    if (known_) {
      b += correction_;
      update(delta - delta_, gradient - gradient_, stiff, b);
      b = within(stiff, b);
    }
    known_ = true;
    delta_ = delta;
    gradient_ = gradient;
    correction_ = b - stiff;
    return b;
  }

 private:
  static void update(const Vector& step, const Vector& change, const Matrix& stiff, Matrix& b) {
    const Vector bs = b * step;
    const double sbs = step.dot(bs);
    const double sy = step.dot(change);
    if (!(sbs > 0) || !(sy > kLeast * step.dot(stiff * step))) return;
    b += change * change.transpose() / sy - bs * bs.transpose() / sbs;
  }
  /// b with its eigenvalues relative to the stiff Hessian clamped to [kLeast, 1].
  static Matrix within(const Matrix& stiff, const Matrix& b) {
    const Eigen::LLT<Matrix> llt(stiff);
    if (llt.info() != Eigen::Success) return stiff;
    const Matrix root = llt.matrixL();
    const Matrix inner = root.template triangularView<Eigen::Lower>().solve(b);
    Matrix relative = root.template triangularView<Eigen::Lower>().solve(inner.transpose());
    relative = 0.5 * (relative + relative.transpose()).eval();
    const auto eigen = eigenpairs<N>(relative);
    const Vector held = eigen.values.cwiseMax(kLeast).cwiseMin(1.0);
    const Matrix vectors = root * eigen.vectors;
    const Matrix out = vectors * held.asDiagonal() * vectors.transpose();
    return out.allFinite() ? out : stiff;
  }

  // Least fraction of the Gauss–Newton curvature: a smaller value mostly gives a step that is many
  // times too long.
  static constexpr double kLeast = 0.2;
  bool known_ = false;
  Vector delta_, gradient_;
  Matrix correction_;
};

}  // namespace nav::registration
