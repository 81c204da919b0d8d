// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "nav/volume.hpp"
#include "session/critical_structures.hpp"

namespace nav::session {

/// Distance of one point from the nearest critical structure.
struct NearestStructure {
  enum class State {
    kNone,     ///< There are no structures.
    kPending,  ///< The distances are being computed.
    kUnknown,  ///< The point lies where no distances were computed.
    kFar,      ///< No structure of values within kFarthestClearanceMm, and there are no spheres.
    kKnown,
  };
  State state = State::kNone;
  double distance_mm = 0;  ///< kKnown: from the surface; negative: inside.
  std::string name{};      ///< kKnown: of the nearest structure.
  std::string too_near{};  ///< kKnown: name of one that is nearer than its clearance; may be empty.
};

/// Distances from the critical structures of a plan, made once for the plan: closed form for
/// spheres; for values of the CT a signed distance field (exact Euclidean transform, Felzenszwalb
/// and Huttenlocher 2012) of the box around the path and kFarthestClearanceMm beyond it. The
/// surface of values lies half the longest edge of a voxel outside of the voxels' centres; between
/// centres the field is interpolated, so that a distance is right within one such edge. Immutable;
/// thread-safe.
class StructureDistances {
 public:
  /// Time: up to seconds for each structure of values in a fine CT. Deterministic.
  static StructureDistances create(const NeedlePlan& plan,
                                   const std::vector<CriticalStructure>& structures,
                                   const Volume& ct);

  [[nodiscard]] NearestStructure nearest(const Point<frames::Ct>& point) const;

 private:
  using Field = VolumeOf<frames::Ct, float>;
  struct One {
    CriticalStructure structure;
    std::shared_ptr<const Field> field;  ///< Null for a sphere.
  };
  std::vector<One> all_;
};

}  // namespace nav::session
