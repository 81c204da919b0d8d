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
#include "registration/acceptance.hpp"
#include "registration/shape/shape_field.hpp"
#include "registration/uncertainty/observability.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// How points are laid onto a shape.
struct ShapeRegistrationOptions {
  double keep_fraction = 0.95;    ///< Nearest share of the points that counts, (0.3, 1].
  double noise_mm = 0.5;          ///< Robust scale never sinks below this, > 0.
  int max_points = 2000;          ///< Every so many-th is used beyond, >= 20.
  int max_rounds = 30;            ///< Of trimming and solving, >= 1.
  int starts = 2000;              ///< Seeded starts ranked by distance, >= 0; 0: the initial alone.
  double start_range_mm = 30;     ///< Half width of their box of translations, >= 0.
  double start_range_rad = 0.35;  ///< Half width of their box of rotation vectors, [0, pi].
  /// A direction in which 1 mm (of the points' mean lever arm) changes their offsets by less than
  /// the root of this share is not determined by the shape: it stays as the start has it, > 0.
  double least_strength = 4e-3;
  std::uint64_t seed = 1;
};

/// A refusal that names the first option out of its range.
Result<void> validate(const ShapeRegistrationOptions& options);

/// How far the points lie from the shape, mm: every point, none trimmed.
struct DistanceSummary {
  double mean_mm, median_mm, rms_mm, p95_mm;
};

/// The whole story of laying points onto a shape.
struct ShapeRegistration {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  DistanceSummary before;  ///< At the initial pose.
  DistanceSummary after;
  int points;       ///< Used.
  int trimmed;      ///< Of these, too far to count.
  double scale_mm;  ///< Robust standard deviation of the offsets that count.
  int iterations;   ///< Of the chosen start, all rounds.
  bool converged;
  std::vector<SlidingDirection> sliding;  ///< Not determined; empty: all six are.
  /// (mean distance of the best other minimum − own) / own; other: more than 5 mm away. Absent when
  /// no start ended in one.
  std::optional<double> margin;
  /// About the centroid of the points; of the directions that are determined. Correlated in cubes
  /// of 20, 40 or 80 mm, whichever says more.
  PoseUncertainty uncertainty;
  /// What points and shape disagree about besides noise, one axis, standard deviation
  /// (shape_discrepancy.hpp): a target moves with it as the surface does, whatever the pose.
  double discrepancy_mm = 0;

  /// Expected RMS error at a point of the CT, mm, of pose and discrepancy; infinite while a
  /// direction slides. Errors that all points share and the pose absorbs are not in it.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const {
    if (!sliding.empty()) return std::numeric_limits<double>::infinity();
    return std::hypot(uncertainty.tre_rms_mm(target), std::sqrt(3.0) * discrepancy_mm);
  }
};

/// Lays tracked surface points onto a surface, or points along vessels onto centre lines: robust
/// (Huber) least squares of the offsets that the shape does not leave free, trimmed (Chetverikov et
/// al. 2002), from the initial pose and from seeded starts ranked by distance; Ceres, exact
/// Jacobians, twists about the points' centroid. Directions that the shape leaves free altogether
/// are found from the curvature, kept as the start has them and named.
/// keep_going: asked between solves; false ends with kCancelled.
/// Errors: kUsage (options), kMalformedData (fewer than 20 points, points that are not finite or
/// beyond 1e7 mm),
/// kRefused (points that coincide), kCancelled. Thread-safe, deterministic.
Result<ShapeRegistration> register_points(std::span<const Point<frames::Reference>> points,
                                          const ShapeField& shape,
                                          const Transform<frames::Ct, frames::Reference>& initial,
                                          const ShapeRegistrationOptions& options = {},
                                          const std::function<bool()>& keep_going = {});

/// What laying onto a shape must show. Inclusive.
struct ShapeLimits {
  double max_mean_mm = 3;     ///< Of the distances of all points, > 0.
  double min_margin = 0.15;   ///< To another minimum, where one was found.
  double max_tre_rms_mm = 2;  ///< Predicted at the target, > 0.
};
inline constexpr ShapeLimits kShapeWarnings{
    .max_mean_mm = 2.5, .min_margin = 0.3, .max_tre_rms_mm = 1};

/// Judges a result for use at a target. A value that is not finite never passes; every sliding
/// direction is a reason to refuse, named.
Decision decide(const ShapeRegistration& result, const ShapeLimits& limits,
                const Point<frames::Ct>& target, const ShapeLimits& warnings = kShapeWarnings);

}  // namespace nav::registration
