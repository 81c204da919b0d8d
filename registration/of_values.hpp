// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "nav/matrices.hpp"
#include "registration/twist.hpp"

/// Functions of symmetric 6 × 6 matrices, applied to their eigenvalues.
namespace nav::registration {

/// Returns V f(λ) Vᵀ.
template <class Function>
Matrix6d of_values(const Matrix6d& symmetric, const Function& f) {
  const auto pairs = eigenpairs(symmetric);
  return pairs.vectors * pairs.values.unaryExpr(f).asDiagonal() * pairs.vectors.transpose();
}

/// Square root of a value (0 for a negative value), and its inverse.
inline constexpr auto square_root = [](double value) { return std::sqrt(std::max(value, 0.0)); };
inline constexpr auto inverse_square_root = [](double value) { return 1 / square_root(value); };

/// S with S B Sᵀ = A for positive definite A and B. It maps Hessians whose sum is B to Hessians
/// whose sum is A.
inline Matrix6d turning_into(const Matrix6d& a, const Matrix6d& b) {
  return of_values(a, square_root) * of_values(b, inverse_square_root);
}

}  // namespace nav::registration
