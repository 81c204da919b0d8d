// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "nav/transform.hpp"

/// Evidence in the residuals of points for and against a registration to a shape.
namespace nav::registration {

/// Noise of points about a shape, from the residuals at a pose.
struct ShapeNoise {
  double sigma_mm;  ///< Robust standard deviation of a residual, with the part that points share.
  /// Standard deviation of the part that neighbouring points do not share, from the differences of
  /// residuals within a few millimetres (the nugget of a variogram; Matheron 1963). Absent if
  /// hardly any points are neighbours.
  std::optional<double> rough_mm;
  /// Number of points that carry independent residuals: points within 5 mm of each other count
  /// once, and residuals that neighbours share reduce it (design effect; Kish 1965).
  double independent_points;
};

/// Least-squares explanations of the residuals, each together with a free rigid pose.
struct ShapeStrain {
  /// Principal stretches of the points that fit the shape best, ascending; 0: none. 0.05: the shape
  /// is 5 % larger than the points show it. Strains far beyond 10 % are unlikely a priori.
  Eigen::Vector3d stretches;
  Eigen::Vector3d longest_ct;  ///< Direction of the largest stretch by size, unit, Ct.
  double moved_mm;  ///< RMS motion of the points by the strain, with the pose that goes with it.
  /// Standard error of that motion: how far the points may lie from where they belong because the
  /// shape may be that of another patient or level.
  double moved_sigma_mm;
  double evidence;  ///< Log-likelihood gained by the strain, for independent points.
  /// Best stretch that is the same in all directions, and its standard error; infinite if the pose
  /// takes such a stretch up.
  double scale, scale_sigma;
  /// Distance of all points from the surface on one side, along the mesh's normals, and its
  /// standard error; infinite if the pose takes such a distance up. Of surfaces only.
  double shared_mm, shared_sigma_mm;
};

/// A pose of the shape, or of its mirror image, that explains the points.
struct ShapeRival {
  /// Pose of the points; for the mirror image the pose of the points with x of Reference negated.
  Transform<frames::Ct, frames::Reference> pose;
  bool mirrored;
  double mean_mm;  ///< Mean distance of the points that count.
  /// Log-likelihood of the registration less that of the rival, for independent points; negative:
  /// the rival explains the points better.
  double evidence;
  double apart_mm;    ///< RMS distance of the points from where the registration puts them.
  double turned_deg;  ///< Rotation between the two; of a mirror image 0.
};

struct ShapeRivals {
  std::vector<ShapeRival> turned;      ///< Rivals of the shape itself, strongest first.
  std::optional<ShapeRival> mirrored;  ///< The strongest one of the mirror image.
  /// The shape is its own mirror image within the noise: its left and right cannot differ.
  bool own_mirror_image = false;
};

/// The evidence for a registration in which no direction slides.
struct ShapeEvidence {
  ShapeNoise noise;
  ShapeStrain strain;
  ShapeRivals rivals;
};

}  // namespace nav::registration
