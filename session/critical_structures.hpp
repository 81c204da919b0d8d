// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "nav/volume.hpp"

namespace nav::session {

/// A structure that a planned path has to stay away from: a sphere, or all voxels of the CT whose
/// values lie in a range (contrast-filled vessels, bone). Exactly one of both.
struct CriticalStructure {
  std::string name{};  ///< Unique, not empty.
  struct Sphere {
    Point<frames::Ct> centre_ct;
    double radius_mm = 5;  ///< 0.1 to 500.
  };
  std::optional<Sphere> sphere{};
  struct Values {
    double low_hu = 0;
    double high_hu = 0;  ///< Above low_hu.
  };
  std::optional<Values> values{};
  double clearance_mm = 5;  ///< Distance that a path has to keep, 0 to 100.
};

/// Rejects values out of range, by key of the session file, and names that come twice.
Result<void> validate(const std::vector<CriticalStructure>& structures);

/// Distance of a path from one structure.
struct PathClearance {
  std::string name{};
  /// From the path to the surface, mm; negative: through a sphere. Of values: to the centre of the
  /// nearest voxel, looked for within kFarthestClearanceMm; absent: there is none so near.
  std::optional<double> distance_mm{};
  Point<frames::Ct> nearest_ct{{0, 0, 0}};  ///< Point of the structure; unused without a distance.
  bool too_near = false;                    ///< Nearer than its clearance.
};
inline constexpr double kFarthestClearanceMm = 30;

/// A planned path against the structures.
struct PathCheck {
  double length_mm = 0;  ///< Entry to target.
  /// Angle between the path and the axial plane, [0, pi/2] rad.
  double angle_to_axial_rad = 0;
  std::vector<PathClearance> clearances{};  ///< In the order of the structures.
};
/// Checks the straight path from the entry to the target. Reads the voxels near the path for each
/// structure of values: tens of ms. Thread-safe, deterministic.
PathCheck check_path(const NeedlePlan& plan, const std::vector<CriticalStructure>& structures,
                     const Volume& ct);

}  // namespace nav::session
