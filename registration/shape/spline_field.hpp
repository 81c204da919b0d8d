// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <optional>
#include <vector>

#include "registration/similarity/ct_channels.hpp"

namespace nav::registration {

/// A displacement in Ct, mm: uniform cubic B-splines over a box, fading to zero outside.
class SplineField {
 public:
  /// With more control points bending() takes gigabytes.
  static constexpr double kMostControlPoints = 32768;
  /// Number of control points of a field over a box; infinite if the box is not finite.
  static double control_points_over(const CtBox& box, double spacing_mm);
  /// spacing_mm > 0 is the distance of the control points; the box is covered with two more points
  /// on each side. Precondition: at most kMostControlPoints.
  SplineField(const CtBox& box, double spacing_mm);

  /// Up to 64 control points that affect a point, and their weights (sum 1 inside the box).
  struct Reach {
    std::array<int, 64> index;
    std::array<double, 64> weight;
    std::array<Eigen::Vector3d, 64> slope;  ///< Gradient of the weight, per mm.
    int count = 0;
  };
  [[nodiscard]] Reach reach(const Eigen::Vector3d& p_ct_mm) const;

  [[nodiscard]] Eigen::Vector3d displacement(const Eigen::Vector3d& p_ct_mm) const;
  /// displacement() along a line in x, four times as fast: the sums over y and z are taken once.
  class Row {
   public:
    /// Equals the field at the line's y and z, to rounding.
    [[nodiscard]] Eigen::Vector3d displacement(double x_ct_mm) const;
    /// True if no control point affects the line.
    [[nodiscard]] bool empty() const { return sums_.empty(); }

   private:
    friend class SplineField;
    double origin_mm_ = 0, spacing_mm_ = 1;
    std::vector<Eigen::Vector3d> sums_;  ///< Padded with two zeros at either end.
  };
  [[nodiscard]] Row row(double y_ct_mm, double z_ct_mm) const;
  /// d displacement / d p, closed form.
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d& p_ct_mm) const;
  /// Smallest determinant of I + jacobian() on a grid of a quarter spacing over the box; it is <= 0
  /// if tissue folds.
  [[nodiscard]] double min_determinant() const;

  /// Upper bound of |u(a) − u(b)| / |a − b| anywhere. The slope of a spline along an axis is a mean
  /// of the differences of neighbouring coefficients over the spacing, and the bounds of the three
  /// axes add up in squares. Below 1 the map is one-to-one (a contraction moves no two points
  /// together).
  [[nodiscard]] double gradient_bound() const;

  /// Matrix of the bending energy: coefficientsᵀ (bending ⊗ I₃) coefficients is the integral over
  /// space of the squared second derivatives of all three components, mm. Exact; symmetric,
  /// positive definite.
  [[nodiscard]] Eigen::SparseMatrix<double> bending() const;

  /// The bending energy of this field, mm.
  [[nodiscard]] double bending_energy_mm() const;

  [[nodiscard]] double spacing_mm() const { return spacing_mm_; }
  /// Position of control point (0, 0, 0), Ct, mm.
  [[nodiscard]] const Eigen::Vector3d& origin() const { return origin_; }
  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }
  [[nodiscard]] int control_points() const { return size_[0] * size_[1] * size_[2]; }
  /// Three per control point.
  [[nodiscard]] const Eigen::VectorXd& coefficients() const { return coefficients_; }
  void set_coefficients(const Eigen::VectorXd& mm);

 private:
  struct Near;
  [[nodiscard]] std::optional<Near> near(const Eigen::Vector3d& p_ct_mm) const;
  /// Index of control point (a, b, c) among those near.
  [[nodiscard]] int index(const Near& at, std::size_t a, std::size_t b, std::size_t c) const;

  CtBox box_;
  double spacing_mm_;
  Eigen::Vector3d origin_;  ///< Position of control point (0, 0, 0).
  std::array<int, 3> size_{};
  Eigen::VectorXd coefficients_;
};

}  // namespace nav::registration
