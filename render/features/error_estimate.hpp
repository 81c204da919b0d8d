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

/// Estimates the error of preconditioned conjugate gradients from numbers that the iteration
/// computes anyway. Not thread-safe.
///
/// Let t be the least eigenvalue of M A. The error e obeys e · A e <= r · z / t with z = M r. The
/// steps are a Lanczos process. Its tridiagonal matrix gives an upper bound of t, which is close
/// once the smooth parts, which converge last, dominate. The remaining error resembles the last
/// directions p, so its length |e| / (e · A e)^½ is taken to be their greatest |p| / (p · A p)^½
/// (Golub and Meurant 2010; this last step is no bound). While t still falls, both t and this
/// length are assumed to change further as they did during these directions; e is then proportional
/// to 1 / t.
class ErrorEstimate {
 public:
  /// Starts again from a new residual. Knowledge of M A remains.
  void restart();
  /// Adds a step along p. \p rz: r · z before the step; \p pap: p · A p; \p pp: p · p; all > 0.
  void add_step(double rz, double pap, double pp);
  /// Estimated |e| for a given r · z; infinite before kDirections steps.
  [[nodiscard]] double error(double rz) const;
  /// Estimate of error() after any number of steps, for a solution that these steps nearly reached.
  /// Precondition: at least one step.
  [[nodiscard]] double error_of_few(double rz) const;
  /// Upper bound of t; infinite before the first step.
  [[nodiscard]] double least_eigenvalue() const { return least_; }

  static constexpr int kDirections = 4;  ///< With fewer directions t is mostly wrong; with more, p
                                         ///< is too old.

 private:
  void find_least();
  std::vector<double> diagonal_, beside_;  ///< Entries of the tridiagonal matrix.
  double last_rz_ = 0, last_alpha_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  std::array<double, kDirections> length_{};  ///< |p| / (p · A p)^½.
  std::array<double, kDirections> before_{};  ///< t before the step; for the first step, t after
                                              ///< it.
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

/// Finds the least eigenvalue by bisection: all pivots of the matrix minus s are positive if s is
/// below all eigenvalues.
inline void ErrorEstimate::find_least() {
  const auto below_all = [&](double s) {
    double pivot = diagonal_[0] - s;
    for (std::size_t n = 1; n < diagonal_.size() && pivot > 0; ++n) {
      pivot = diagonal_[n] - s - beside_[n - 1] * beside_[n - 1] / pivot;
    }
    return pivot > 0;
  };
  least_ = std::min(least_, diagonal_[0]);  // The least eigenvalue never exceeds a diagonal entry.
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
