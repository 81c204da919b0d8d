// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "registration/shape/shape_evidence.hpp"
#include "registration/shape/shape_field.hpp"
#include "registration/uncertainty/observability.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Options of the registration of points to a shape.
struct ShapeRegistrationOptions {
  /// Fraction of the points that is used (the nearest ones), (0.3, 1].
  double keep_fraction = 0.95;
  double noise_mm = 0.5;  ///< Least value of the robust scale, > 0.
  int max_points = 2000;  ///< If there are more points, an even choice is used, >= 20.
  int max_rounds = 30;    ///< Limit of rounds of trimming and solving, >= 1.
  int starts = 2000;      ///< Seeded starts ranked by distance, >= 0; 0: the initial pose alone.
  double start_range_mm = 30;     ///< Half width of the starts' box of translations, >= 0.
  double start_range_rad = 0.35;  ///< Half width of the starts' box of rotation vectors, [0, pi].
  /// Least observable strength, > 0. If 1 mm along a direction (at the points' mean lever arm)
  /// changes the offsets by less than the square root of this fraction, the shape does not
  /// determine the direction: it stays as in the start.
  double least_strength = 4e-3;
  std::uint64_t seed = 1;
  /// Least noise that the evidence for and against rivals assumes, > 0: the field's own errors.
  double least_sigma_mm = 0.25;
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const ShapeRegistrationOptions& options);

/// Distances of all points from the shape, mm; none is trimmed.
struct DistanceSummary {
  double mean_mm, median_mm, rms_mm, p95_mm;
};

/// The complete result of a registration of points to a shape.
struct ShapeRegistration {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  DistanceSummary before;  ///< At the initial pose.
  DistanceSummary after;
  int points;       ///< Points used.
  int trimmed;      ///< Used points that are too far away to count.
  double scale_mm;  ///< Robust standard deviation of the offsets of the points that count.
  int iterations;   ///< Iterations of the chosen start in all rounds.
  bool converged;
  /// Directions that are not determined; empty: all six are.
  std::vector<SlidingDirection> sliding;
  /// (mean distance of the best other minimum − own) / own; another minimum is more than 5 mm away.
  /// Absent if no start ended in one.
  std::optional<double> margin;
  /// Uncertainty about the centroid of the points, for the directions that are determined. Errors
  /// are taken as correlated in cubes of 20, 40 or 80 mm, whichever gives the larger uncertainty.
  PoseUncertainty uncertainty;
  /// Disagreement of points and shape beyond noise, one axis, standard deviation
  /// (shape_discrepancy.hpp). A target moves with it as the surface does, whatever the pose.
  double discrepancy_mm = 0;
  /// An even choice of at most 80 of the points, to compare poses.
  std::vector<Point<frames::Reference>> some_points{};
  /// Rivals and other explanations; absent if a direction slides.
  std::optional<ShapeEvidence> evidence{};

  /// Expected RMS error at a point of the CT, mm, from the pose and the discrepancy; infinite if a
  /// direction slides. It does not include errors that all points share and the pose absorbs.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const {
    if (!sliding.empty()) return std::numeric_limits<double>::infinity();
    return std::hypot(uncertainty.tre_rms_mm(target), std::sqrt(3.0) * discrepancy_mm);
  }
};

/// Registers tracked surface points to a surface, or points along vessels to centre lines. It
/// minimises by robust (Huber), trimmed (Chetverikov et al. 2002) least squares the offsets that
/// the shape does not leave free, from the initial pose and from seeded starts ranked by distance;
/// Levenberg–Marquardt with exact Jacobians, twists about the points' centroid. Directions that the
/// shape leaves free altogether are found from the curvature, kept as in the start and named.
/// keep_going: asked between solves; false ends with kCancelled.
/// Errors: kUsage (options), kMalformedData (fewer than 20 points, points that are not finite or
/// beyond 1e7 mm), kRefused (points that coincide), kCancelled. Thread-safe, deterministic.
Result<ShapeRegistration> register_points(std::span<const Point<frames::Reference>> points,
                                          const ShapeField& shape,
                                          const Transform<frames::Ct, frames::Reference>& initial,
                                          const ShapeRegistrationOptions& options = {},
                                          const std::function<bool()>& keep_going = {});

}  // namespace nav::registration
