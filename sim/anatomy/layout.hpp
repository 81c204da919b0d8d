// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/anatomy/organ_stack.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/random.hpp"

/// What the families beside the abdomen have in common. Private to sim/. CT coordinates, mm.
namespace nav::sim {

/// All that makes a patient of a family.
struct Layout {
  std::vector<Organ> organs;
  Field skin_mm = [](const auto& p) { return p.norm() - 1.0; };
  Eigen::AlignedBox3d box;     ///< Of all organs.
  Eigen::AlignedBox3d region;  ///< Worth scanning.
  double cell_mm = 3;
  Blend blend{0.5, 0.3};
  std::vector<NamedPoint> landmarks;
  std::vector<Point<frames::Ct>> targets;
  std::vector<StandardView> views;

  void add(Tissue tissue, const shapes::Ellipsoid& e, const Grain& grain = {});
  void add(Tissue tissue, const shapes::Capsule& c, const Grain& grain = {});
  /// Without bounds of its own: everywhere in the box.
  void add(Tissue tissue, Field distance_mm, const Grain& grain = {});
  void add(Tissue tissue, Field distance_mm, const Eigen::AlignedBox3d& bounds,
           const Grain& grain = {});
  void mark(std::string name, const Vec3d& p);
  /// count targets where accept holds, spread evenly over the region.
  void place_targets(int count, const std::function<bool(const Vec3d&)>& accept);
  /// A probe on the skin above a point: outward is where the operator stands, sideways is as near
  /// to the picture's +x as can be.
  void view(std::string name, const ProbeModel& probe, const Vec3d& over, const Vec3d& outward,
            const Vec3d& sideways);
};

/// The patient of a layout.
Patient finish(std::string family, const PatientOptions& options, Layout layout);

/// Where a ray from inside leaves the skin; along: unit.
Vec3d leave_skin(const Field& skin_mm, const Vec3d& inside, const Vec3d& along);

/// Muscle fibres along a direction, in bundles that septa part.
Grain muscle_grain(const Vec3d& along);

/// Families, one file each.
Patient make_abdomen(const PatientOptions& options);
Patient make_neck(const PatientOptions& options);
Patient make_shoulder(const PatientOptions& options);
Patient make_tendon(const PatientOptions& options);
Patient make_head(const PatientOptions& options);
Patient make_spine(const PatientOptions& options);

}  // namespace nav::sim
