// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace nav::render::features {

/// How far preconditioned conjugate gradients are from the solution, from numbers that they have at
/// hand. Not thread-safe.
///
/// With the least eigenvalue t of M A the error e obeys e · A e <= r · z / t (z = M r). Steps are a
/// Lanczos process, whose tridiagonal matrix knows t from above, closely once the smooth parts
/// count that converge last. What is left looks like the last directions p: it has |e| / (e · A
/// e)^½ as the greatest |p| / (p · A p)^½ of them (Golub and Meurant 2010; the last step is no
/// bound). While t still falls both are taken to go on as they did during these directions: e goes
/// by 1 / t.
class ErrorEstimate {
 public:
  /// Steps begin from a new residual; what is known of M A remains.
  void restart();
  /// rz: r · z before the step along p, whose p · A p and p · p follow; all > 0.
  void add_step(double rz, double pap, double pp);
  /// |e| where r · z is that; infinite before kDirections steps.
  [[nodiscard]] double error(double rz) const;
  /// The same from however few steps, of a solution that these all but reached. Precondition: a
  /// step.
  [[nodiscard]] double error_of_few(double rz) const;
  /// t, from above; infinite before the first step.
  [[nodiscard]] double least_eigenvalue() const { return least_; }

  static constexpr int kDirections = 4;  ///< Of fewer t is mostly wrong, of more p is of the past.

 private:
  void find_least();
  std::vector<double> diagonal_, beside_;  ///< Of the tridiagonal matrix.
  double last_rz_ = 0, last_alpha_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  std::array<double, kDirections> length_{};  ///< |p| / (p · A p)^½.
  std::array<double, kDirections> before_{};  ///< t before the step; of the first one after it.
  int steps_ = 0;
};

inline void ErrorEstimate::restart() {
  diagonal_.clear();
  beside_.clear();
}

inline void ErrorEstimate::add_step(double rz, double pap, double pp) {
  const double alpha = rz / pap;
  if (diagonal_.empty()) {
    diagonal_.push_back(1 / alpha);
  } else {
    const double beta = rz / last_rz_;
    diagonal_.push_back(1 / alpha + beta / last_alpha_);
    beside_.push_back(std::sqrt(beta) / last_alpha_);
  }
  last_rz_ = rz;
  last_alpha_ = alpha;
  const auto slot = static_cast<std::size_t>(steps_ % kDirections);
  length_[slot] = std::sqrt(pp / pap);
  before_[slot] = least_;
  find_least();
  if (steps_ == 0) before_[slot] = least_;
  ++steps_;
}

inline double ErrorEstimate::error(double rz) const {
  if (steps_ < kDirections) return std::numeric_limits<double>::infinity();
  return error_of_few(rz);
}

inline double ErrorEstimate::error_of_few(double rz) const {
  const int oldest = steps_ < kDirections ? 0 : steps_ % kDirections;
  const double falling = before_[static_cast<std::size_t>(oldest)] / least_;
  return falling * std::sqrt(rz / least_) * *std::ranges::max_element(length_);
}

/// By bisection: all pivots of the matrix less s are positive where s is below all eigenvalues.
inline void ErrorEstimate::find_least() {
  const auto below_all = [&](double s) {
    double pivot = diagonal_[0] - s;
    for (std::size_t n = 1; n < diagonal_.size() && pivot > 0; ++n) {
      pivot = diagonal_[n] - s - beside_[n - 1] * beside_[n - 1] / pivot;
    }
    return pivot > 0;
  };
  least_ = std::min(least_, diagonal_[0]);  // All eigenvalues are not above one of these.
  if (diagonal_.size() == 1 || below_all(least_)) return;
  constexpr int kHalvings = 40;
  double low = 0;
  for (int n = 0; n < kHalvings; ++n) {
    const double middle = 0.5 * (low + least_);
    if (below_all(middle)) {
      low = middle;
    } else {
      least_ = middle;
    }
  }
}

}  // namespace nav::render::features
