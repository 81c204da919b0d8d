// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "nav/result.hpp"

namespace nav::sim {

/// Motion of the tissue: a one-to-one map from the patient at rest (end of expiration, as in the
/// CT) to the patient at one moment, both in Ct, mm. Implementations are thread-safe to read.
class Warp {
 public:
  virtual ~Warp() = default;
  /// Present position of the tissue that is at \p rest at rest.
  [[nodiscard]] virtual Eigen::Vector3d apply(const Eigen::Vector3d& rest) const = 0;
  /// d apply / d rest, closed form; its determinant is positive everywhere.
  [[nodiscard]] virtual Eigen::Matrix3d jacobian(const Eigen::Vector3d& rest) const = 0;
  /// Position at rest of the tissue that is at \p now: |apply(invert(p)) - p| <=
  /// kInverseToleranceMm.
  [[nodiscard]] virtual Eigen::Vector3d invert(const Eigen::Vector3d& now) const = 0;
  static constexpr double kInverseToleranceMm = 1e-9;
};

/// p' = matrix · p + shift: rigid when the matrix is a rotation.
class AffineWarp final : public Warp {
 public:
  /// Precondition: finite, determinant > 0.01, otherwise a Bug.
  AffineWarp(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& shift_mm);
  /// Rotation by a vector (rad) about a centre, then a shift.
  static AffineWarp rigid(const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& centre_mm,
                          const Eigen::Vector3d& shift_mm);
  [[nodiscard]] Eigen::Vector3d apply(const Eigen::Vector3d& rest) const override {
    return matrix_ * rest + shift_mm_;
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d&) const override { return matrix_; }
  [[nodiscard]] Eigen::Vector3d invert(const Eigen::Vector3d& now) const override {
    return inverse_ * (now - shift_mm_);
  }

 private:
  Eigen::Matrix3d matrix_, inverse_;
  Eigen::Vector3d shift_mm_;
};

/// Displacement that decreases with the distance from a centre: peak_mm · exp(−½ Σ ((p −
/// c)/sigma)²).
struct WarpBump {
  Eigen::Vector3d centre_mm;
  Eigen::Vector3d sigma_mm;  ///< Along the axes of Ct, > 0.
  Eigen::Vector3d peak_mm;
};

/// Sum of bumps. It is one-to-one because its displacement is a contraction: the distance of two
/// points shrinks at most to 1 − lipschitz() of its value.
class SmoothWarp final : public Warp {
 public:
  static constexpr double kMaxLipschitz = 0.9;
  /// Rejects bumps that are not finite, widths that are not positive, and sets that are so steep
  /// together that tissue could fold (lipschitz() > kMaxLipschitz).
  static Result<SmoothWarp> create(std::vector<WarpBump> bumps);
  [[nodiscard]] const std::vector<WarpBump>& bumps() const { return bumps_; }
  [[nodiscard]] Eigen::Vector3d apply(const Eigen::Vector3d& rest) const override;
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d& rest) const override;
  /// Newton's method with the closed-form Jacobian; otherwise the fixed point p − u(p), which
  /// always converges.
  [[nodiscard]] Eigen::Vector3d invert(const Eigen::Vector3d& now) const override;
  /// Upper bound of |u(a) − u(b)| / |a − b|: Σ |peak| e^(−½) / min(sigma).
  [[nodiscard]] double lipschitz() const { return lipschitz_; }

 private:
  explicit SmoothWarp(std::vector<WarpBump> bumps, double lipschitz)
      : bumps_(std::move(bumps)), lipschitz_(lipschitz) {}
  std::vector<WarpBump> bumps_;
  double lipschitz_;
};

/// Upper bound of the steepness of a set of bumps together; see SmoothWarp::lipschitz().
double steepness(const std::vector<WarpBump>& bumps);

/// Sum of the bumps' displacements at a point, mm.
Eigen::Vector3d displacement(const std::vector<WarpBump>& bumps, const Eigen::Vector3d& rest);

/// Two warps, one after the other: then(first(p)).
class ComposedWarp final : public Warp {
 public:
  /// Precondition: neither is null, otherwise a Bug.
  ComposedWarp(std::shared_ptr<const Warp> first, std::shared_ptr<const Warp> then);
  [[nodiscard]] Eigen::Vector3d apply(const Eigen::Vector3d& rest) const override {
    return then_->apply(first_->apply(rest));
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d& rest) const override {
    return then_->jacobian(first_->apply(rest)) * first_->jacobian(rest);
  }
  [[nodiscard]] Eigen::Vector3d invert(const Eigen::Vector3d& now) const override;

 private:
  std::shared_ptr<const Warp> first_, then_;
};

}  // namespace nav::sim
