// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "registration/shape/shape_registration.hpp"

namespace nav::registration {

using ReferencePoints = std::vector<Point<frames::Reference>>;

/// An even choice of at most count points.
ReferencePoints some_points_of(std::span<const Point<frames::Reference>> points, std::size_t count);

/// Distance of the points between two poses, RMS, mm; 0 without points.
double points_apart_mm(const ReferencePoints& points,
                       const Transform<frames::Ct, frames::Reference>& a,
                       const Transform<frames::Ct, frames::Reference>& b);

/// One local optimisation of points onto a shape.
struct ShapeSolution {
  Transform<frames::Ct, frames::Reference> pose;
  double mean_mm;  ///< Mean distance of the points that count.
  int iterations;
  bool converged;
};

/// Quantities of the points at a pose that the report needs.
struct ShapeCurvature {
  Eigen::Vector3d centre_ct_mm;        ///< Centroid of the points.
  double lever_mm;                     ///< RMS distance from the centroid, >= 1.
  double scale_mm;                     ///< Robust standard deviation of the offsets.
  std::vector<std::size_t> counted{};  ///< Points that are not trimmed.
  std::vector<Eigen::Vector3d> places_ct_mm{}, offsets_mm{};  ///< Values of the counted points.
  /// Gradient of ½ offset² of each counted point, including its robust weight.
  std::vector<Vector6d> gradients{};
  Matrix6d curvature;  ///< Mean JᵀJ over the counted points, by a twist [rad | mm].
};

ShapeCurvature curvature_at(const ReferencePoints& points, const ShapeField& shape,
                            const Transform<frames::Ct, frames::Reference>& pose,
                            const ShapeRegistrationOptions& options);

/// Optimises from a pose in rounds: trim, find the unseen directions, solve in the others.
ShapeSolution descend(const ReferencePoints& points, const ShapeField& shape,
                      const Transform<frames::Ct, frames::Reference>& start,
                      const ShapeRegistrationOptions& options, int max_rounds);

}  // namespace nav::registration
