// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// Usable points of a sweep, sparsely sampled, for the overlap and the distances of poses.
struct SweepPoints {
  std::vector<Point<frames::Reference>> points;
  Point<frames::Reference> centroid;  ///< Mean of the points.
  double radius_mm = 0;               ///< Distance of the farthest point from the centroid.
  /// Mean of (p − centroid)(p − centroid)ᵀ, mm²; distances of poses depend on nothing else.
  Eigen::Matrix3d spread_mm2 = Eigen::Matrix3d::Zero();
};

/// Points 4 mm or more apart in images 4 mm or more apart, inside the masks.
SweepPoints sweep_points(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks);

/// Fraction of the points inside the box of voxel centres and not in its air, where no echo comes
/// from, [0, 1]; 0 if there are no points. ct: channels that tell air from tissue; null: no air.
double overlap(const VoxelGrid& grid, const SweepPoints& sweep, const Pose& pose,
               const CtChannels* ct = nullptr);

/// Mean |M (p − centroid)|² of the points, mm².
double spread_mm2(const SweepPoints& sweep, const Eigen::Matrix3d& m);

/// RMS distance of the points between two poses, mm; in closed form from their spread.
double distance_mm(const SweepPoints& sweep, const Pose& a, const Pose& b);

/// Box that holds all points at all poses, with a margin. Preconditions: neither is empty.
CtBox box_around(const SweepPoints& sweep, const std::vector<Pose>& poses, double margin_mm);

/// Distance between the middles of the images at two poses, RMS, mm.
double apart_mm(const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& a,
                const Transform<frames::Ct, frames::Reference>& b);

}  // namespace nav::registration
