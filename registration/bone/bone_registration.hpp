// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "registration/bone/bone_detector.hpp"
#include "registration/shape/shape_acceptance.hpp"

namespace nav::registration {

/// A position on bone that an image of a sweep shows.
struct BonePoint {
  Point<frames::Reference> at;
  Eigen::Vector3d beam;  ///< Away from the transducer, unit, Reference.
  double confidence;     ///< [0, 1].
};

/// Echoes of at least that confidence, in the order of images and lines. Precondition: one surface
/// for each image of the sweep.
std::vector<BonePoint> bone_points(const BoneOfSweep& bone, const Sweep& sweep,
                                   double least_confidence);

struct BoneRegistrationOptions {
  BoneRegistrationOptions() { shape.keep_fraction = 0.9; }
  /// Options of points on a surface. Echoes of other things are trimmed: a tenth of the points.
  ShapeRegistrationOptions shape;
  double least_confidence = 0.6;  ///< Echoes below do not count, [0, 1].
  /// A piece of the surface can cause an echo if its normal is within this angle of the direction
  /// to some transducer, in the start pose, whose rotation may be wrong, (0, pi].
  double facing_rad = 1.75;
};

/// Result of a registration by bone.
struct BoneRegistration {
  /// To the side that faces the probe; the evidence is that of the whole surface.
  ShapeRegistration shape;
  std::size_t echoes;    ///< Points that were found, before the even choice.
  double share;          ///< Share of all scan lines that meet bone.
  double from_whole_mm;  ///< Distance of the points from where the whole surface, whatever side it
                         ///< faces, would put them, RMS.
};

/// Registers the bone that a sweep shows to the surface of bone in the CT, whose pieces have
/// outward normals. An echo lies on the side that faces the probe, so that the pose is sought on
/// those pieces alone; rivals are sought on all. Errors: kRefused (fewer than 20 points; no surface
/// faces the probe), and those of register_points(). Thread-safe, deterministic.
Result<BoneRegistration> register_bone(const BoneOfSweep& bone, const Sweep& sweep,
                                       const Shape& surface,
                                       const Transform<frames::Ct, frames::Reference>& start,
                                       const BoneRegistrationOptions& options = {},
                                       const std::function<bool()>& keep_going = {});

/// decide() of shapes, with what to show next for each direction that the bone leaves free. A whole
/// surface that puts the points elsewhere is a reason for rejection too. Without a known pose there
/// is always a warning: vertebrae and ribs of another level or patient may fit as well.
Decision decide(const BoneRegistration& result, const ShapeLimits& limits,
                const Point<frames::Ct>& target, const std::optional<KnownPose>& known = {},
                const std::optional<double>& given_sigma_mm = {});

}  // namespace nav::registration
