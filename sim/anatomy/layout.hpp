// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/anatomy/organ_stack.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/random.hpp"

/// Functions shared by the families other than the abdomen. Private to sim/. CT coordinates, mm.
namespace nav::sim {

/// Everything that makes a patient of a family.
struct Layout {
  std::vector<Organ> organs;
  Field skin_mm = [](const auto& p) { return p.norm() - 1.0; };
  Eigen::AlignedBox3d box;     ///< Box of all organs.
  Eigen::AlignedBox3d region;  ///< Box that is useful to scan.
  double cell_mm = 3;
  Blend blend{0.5, 0.3};
  std::vector<NamedPoint> landmarks;
  std::vector<Point<frames::Ct>> targets;
  std::vector<StandardView> views;

  void add(Tissue tissue, const shapes::Ellipsoid& e, const Grain& grain = {});
  void add(Tissue tissue, const shapes::Capsule& c, const Grain& grain = {});
  /// Adds an organ without its own bounds: it may be anywhere in the box.
  void add(Tissue tissue, Field distance_mm, const Grain& grain = {});
  void add(Tissue tissue, Field distance_mm, const Eigen::AlignedBox3d& bounds,
           const Grain& grain = {});
  void mark(std::string name, const Vec3d& p);
  /// Adds \p count targets where \p accept is true, distributed evenly over the region.
  void place_targets(int count, const std::function<bool(const Vec3d&)>& accept);
  /// Adds a view with the probe on the skin above a point. \p outward: direction to the operator.
  /// \p sideways: the image's +x is as near to it as possible.
  void view(std::string name, const ProbeModel& probe, const Vec3d& over, const Vec3d& outward,
            const Vec3d& sideways);
};

/// Makes the patient of a layout.
Patient finish(std::string family, const PatientOptions& options, Layout layout);

/// Point where a ray from inside leaves the skin. \p along: unit vector.
Vec3d leave_skin(const Field& skin_mm, const Vec3d& inside, const Vec3d& along);

/// Muscle fibres along a direction, in bundles that are separated by septa.
Grain muscle_grain(const Vec3d& along);

/// Families; each is in a file of its own.
Patient make_abdomen(const PatientOptions& options);
Patient make_neck(const PatientOptions& options);
Patient make_shoulder(const PatientOptions& options);
Patient make_tendon(const PatientOptions& options);
Patient make_head(const PatientOptions& options);
Patient make_spine(const PatientOptions& options);

}  // namespace nav::sim
