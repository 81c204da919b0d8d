// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <type_traits>

#include "nav/check.hpp"
#include "nav/frames.hpp"
#include "nav/result.hpp"

namespace nav {

/// A position in frame F, mm.
template <class F, class S = double>
struct Point {
  Eigen::Matrix<S, 3, 1> mm;
};

/// Free vector in frame F, unitless or mm; its name says which. Transforms rotate it only.
template <class F, class S = double>
struct Direction {
  Eigen::Matrix<S, 3, 1> v;
};

template <class F, class S>
Direction<F, S> operator-(const Point<F, S>& a, const Point<F, S>& b) {
  return {a.mm - b.mm};
}
template <class F, class S>
Point<F, S> operator+(const Point<F, S>& a, const Direction<F, S>& d) {
  return {a.mm + d.v};
}

/// Rigid map from From-coordinates to To-coordinates: p_to = R p_from + t. It never scales. It has
/// no default: a pose is measured, computed or absent. S may be a ceres::Jet. Parameter order as a
/// vector: [qx qy qz qw | tx ty tz], rotation first, mm.
template <class To, class From, class S = double>
class Transform {
 public:
  using Quaternion = Eigen::Quaternion<S>;
  using Vector = Eigen::Matrix<S, 3, 1>;

  /// Precondition: finite, |q| = 1 within 1e-6 (checked for double), otherwise a Bug.
  Transform(const Quaternion& unit_rotation, const Vector& translation_mm)
      : rotation_(unit_rotation), translation_mm_(translation_mm) {
    if constexpr (std::is_floating_point_v<S>) {
      NAV_CHECK(translation_mm.allFinite(), To::kName, From::kName);
      const S norm = rotation_.norm();
      NAV_CHECK(std::abs(norm - S(1)) < S(1e-6), To::kName, From::kName, norm);
      rotation_.coeffs() /= norm;
    }
  }

  /// Map of a frame to itself; it does not exist between different frames.
  static Transform identity() requires std::is_same_v<To, From> {
    return Transform(Quaternion::Identity(), Vector::Zero());
  }

  [[nodiscard]] const Quaternion& rotation() const { return rotation_; }
  [[nodiscard]] const Vector& translation_mm() const { return translation_mm_; }
  [[nodiscard]] Eigen::Matrix<S, 4, 4> matrix() const {
    Eigen::Matrix<S, 4, 4> m = Eigen::Matrix<S, 4, 4>::Identity();
    m.template topLeftCorner<3, 3>() = rotation_.toRotationMatrix();
    m.template topRightCorner<3, 1>() = translation_mm_;
    return m;
  }

  [[nodiscard]] Transform<From, To, S> inverse() const {
    const Quaternion r = rotation_.conjugate();
    return Transform<From, To, S>(r, -(r * translation_mm_));
  }
  template <class F>
  Transform<To, F, S> operator*(const Transform<From, F, S>& other) const {
    Quaternion r = rotation_ * other.rotation();
    r.coeffs() /= r.norm();
    return Transform<To, F, S>(r, rotation_ * other.translation_mm() + translation_mm_);
  }
  Point<To, S> operator*(const Point<From, S>& p) const {
    return {rotation_ * p.mm + translation_mm_};
  }
  Direction<To, S> operator*(const Direction<From, S>& d) const { return {rotation_ * d.v}; }

 private:
  Quaternion rotation_;
  Vector translation_mm_;
};

/// Largest deviation from a rigid matrix that is accepted.
struct RigidTolerance {
  double orthonormality = 1e-3;  ///< Max |RᵀR − I| element; trackers print 6 digits.
  double last_row = 1e-6;        ///< Max deviation of the last row from 0 0 0 1.
};

namespace detail {
/// Nearest rotation, or an Error that names the defect (NaN, scale, shear, reflection, last row).
Result<Eigen::Quaterniond> rotation_from_matrix(const Eigen::Matrix4d& m, const std::string& name,
                                                const RigidTolerance& tolerance);
}  // namespace detail

/// Converts 16 numbers from outside into a Transform, or rejects them by name. The nearest rotation
/// (polar decomposition) removes the rounding error of text formats.
template <class To, class From>
Result<Transform<To, From>> rigid_from_matrix(const Eigen::Matrix4d& to_from_from,
                                              const RigidTolerance& tolerance = {}) {
  const std::string name = std::string(From::kName) + "To" + std::string(To::kName);
  auto rotation = detail::rotation_from_matrix(to_from_from, name, tolerance);
  if (!rotation) return rotation.error();
  return Transform<To, From>(*rotation, to_from_from.topRightCorner<3, 1>());
}

/// Angle of the rotation between two maps of the same frames, rad in [0, pi].
template <class To, class From>
double rotation_distance_rad(const Transform<To, From>& a, const Transform<To, From>& b) {
  return a.rotation().angularDistance(b.rotation());
}

/// Pose between a (fraction 0) and b (fraction 1): slerp on the shorter arc and linear translation.
/// It never extrapolates. Precondition: fraction in [0, 1], otherwise a Bug.
template <class To, class From>
Transform<To, From> interpolate(const Transform<To, From>& a, const Transform<To, From>& b,
                                double fraction) {
  NAV_CHECK(fraction >= 0.0 && fraction <= 1.0, fraction);
  return Transform<To, From>(a.rotation().slerp(fraction, b.rotation()).normalized(),
                             (1.0 - fraction) * a.translation_mm() + fraction * b.translation_mm());
}

}  // namespace nav
