// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace nav::sim {

/// Number with its exact spatial gradient: forward differentiation by the rules of calculus,
/// without finite differences. At a corner of a function (abs, min, max) the gradient is that of
/// the selected side. Where the slope is infinite or undefined (root or length of zero) the
/// gradient is 0. (Eigen's own AutoDiffScalar keeps references to temporaries in `auto`
/// expressions.)
struct Dual {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< Gradient per mm.

  Dual() = default;
  Dual(double v) : value(v) {}  // NOLINT: plain numbers are duals without slope.
  Dual(double v, const Eigen::Vector3d& g) : value(v), gradient(g) {}

  Dual& operator+=(const Dual& o) { return *this = Dual(value + o.value, gradient + o.gradient); }
  Dual& operator-=(const Dual& o) { return *this = Dual(value - o.value, gradient - o.gradient); }
  Dual& operator*=(const Dual& o) {
    return *this = Dual(value * o.value, gradient * o.value + value * o.gradient);
  }
  Dual& operator/=(const Dual& o) {
    const double quotient = value / o.value;
    return *this = Dual(quotient, (gradient - quotient * o.gradient) / o.value);
  }
  Dual operator-() const { return {-value, -gradient}; }

  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }
};

inline Dual sqrt(const Dual& a) {
  const double root = std::sqrt(a.value);
  if (!(root > 0)) return {root};
  return {root, a.gradient * (0.5 / root)};
}
inline Dual sin(const Dual& a) { return {std::sin(a.value), std::cos(a.value) * a.gradient}; }
inline Dual cos(const Dual& a) { return {std::cos(a.value), -std::sin(a.value) * a.gradient}; }
inline Dual exp(const Dual& a) {
  const double e = std::exp(a.value);
  return {e, e * a.gradient};
}
inline Dual abs(const Dual& a) { return a.value < 0 ? -a : a; }
inline Dual hypot(const Dual& a, const Dual& b) {
  const double h = std::hypot(a.value, b.value);
  if (!(h > 0)) return {h};
  return {h, (a.value * a.gradient + b.value * b.gradient) / h};
}
inline Dual atan2(const Dual& y, const Dual& x) {
  const double square = x.value * x.value + y.value * y.value;
  const double angle = std::atan2(y.value, x.value);
  if (!(square > 0)) return {angle};
  return {angle, (x.value * y.gradient - y.value * x.gradient) / square};
}
/// Precondition: base >= 0.
inline Dual pow(const Dual& a, double exponent) {
  const double power = std::pow(a.value, exponent);
  if (!(a.value > 0)) return {power};
  return {power, exponent * power / a.value * a.gradient};
}
inline double value_of(double a) { return a; }
inline double value_of(const Dual& a) { return a.value; }
/// Constant between its steps, so the gradient is 0.
inline Dual round(const Dual& a) { return {std::round(a.value)}; }

}  // namespace nav::sim

namespace Eigen {
template <>
struct NumTraits<nav::sim::Dual> : NumTraits<double> {
  using Real = nav::sim::Dual;
  using NonInteger = nav::sim::Dual;
  using Nested = nav::sim::Dual;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 4,
    AddCost = 4,
    MulCost = 12
  };
};
}  // namespace Eigen

namespace nav::sim {
using Vec3d = Eigen::Vector3d;
using Vec3Dual = Eigen::Matrix<Dual, 3, 1>;
template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
/// Scalar type (double or Dual) of the position passed to a generic lambda.
template <class P>
using ScalarOf = typename std::remove_cvref_t<P>::Scalar;

/// Position with the gradient of its own coordinates: the start of the differentiation.
inline Vec3Dual seed(const Eigen::Vector3d& p) {
  return {Dual(p.x(), Eigen::Vector3d::UnitX()), Dual(p.y(), Eigen::Vector3d::UnitY()),
          Dual(p.z(), Eigen::Vector3d::UnitZ())};
}
}  // namespace nav::sim
