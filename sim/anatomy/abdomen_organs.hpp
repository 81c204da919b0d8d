// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "nav/plan.hpp"
#include "sim/anatomy/organ.hpp"
#include "sim/random.hpp"

/// Layout of the phantom's organs. Private to sim/. CT coordinates, mm.
namespace nav::sim {

inline constexpr double kSkinMm = 2;

/// Parameters that differ between patients.
struct Build {
  shapes::SuperEllipse body{142, 100};
  shapes::Ellipsoid right_dome, left_dome;
  shapes::Ellipsoid right_lobe, left_lobe, visceral;
  shapes::Ellipsoid right_kidney, left_kidney, gallbladder;
  double fat_mm = 9;
  double wave_phase[4] = {};
  double spine_phase_mm = 0;

  explicit Build(std::uint64_t seed);
  template <class S>
  [[nodiscard]] S fat_thickness_mm(const Vec3<S>& p) const {
    using std::abs;
    return fat_mm * (1.0 + 0.35 * abs(p.y()) / body.b);
  }
  template <class S>
  [[nodiscard]] S wall_thickness_mm(const Vec3<S>& p) const {
    // The back muscles fill the space behind the organs.
    const S back = shapes::smooth_step(S((p.y() / body.b - 0.25) / 0.7));
    return kSkinMm + fat_thickness_mm(p) + 9.0 + 16.0 * back;
  }
  /// Negative inside the abdominal and chest wall.
  template <class S>
  [[nodiscard]] S cavity_mm(const Vec3<S>& p) const {
    return body(p) + wall_thickness_mm(p);
  }
  /// Negative below the diaphragm.
  template <class S>
  [[nodiscard]] S abdomen_mm(const Vec3<S>& p) const {
    const S domes = shapes::smooth_union(right_dome(p), left_dome(p), 25);
    return shapes::smooth_union(domes, S(p.z() + 18), 25);
  }
  template <class S>
  [[nodiscard]] S liver_mm(const Vec3<S>& p) const {
    using std::sin;
    S d = shapes::smooth_union(right_lobe(p), left_lobe(p), 25);
    d = shapes::smooth_difference(d, visceral(p), 18);
    d = shapes::smooth_difference(d, S(right_kidney(p) - 5), 12);
    // Shallow waves give each liver another outline.
    d += 1.8 * sin(0.055 * p.x() + wave_phase[0]) * sin(0.05 * p.y() + wave_phase[1]) +
         1.5 * sin(0.06 * p.z() + wave_phase[2]) * sin(0.045 * p.x() + wave_phase[3]);
    d = shapes::smooth_intersection(d, S(abdomen_mm(p) + 3.5), 8);
    return shapes::smooth_intersection(d, S(cavity_mm(p) + 1.5), 8);
  }
};

/// Box that contains the surfaces of the organs.
Eigen::AlignedBox3d anatomy_bounds();

/// Adds wall layers, soft organs, spine, ribs and lung, but not the lesion and the liver vessels.
void add_body_wall(const Build& build, std::vector<Organ>& organs);
void add_digestive(const Build& build, Random& random, std::vector<Organ>& organs);
void add_kidneys(const Build& build, Random& random, std::vector<Organ>& organs);
void add_liver(const Build& build, std::vector<Organ>& organs);
void add_great_vessels(std::vector<Organ>& organs);
void add_thorax(const Build& build, std::vector<Organ>& organs);
void add_spine(const Build& build, std::vector<Organ>& organs);
void add_ribs(const Build& build, Random& random, std::vector<Organ>& organs);

/// Chooses a lesion and a path to it that avoids bone, cartilage, lung, gas and gallbladder. A Bug
/// when no position in the liver has one.
NeedlePlan choose_plan(const Build& build, const std::vector<Organ>& organs, Random& random);

/// Sample points of a box with low discrepancy (Halton 2, 3, 5); index from 1.
Eigen::Vector3d halton_in(const Eigen::AlignedBox3d& box, int index);

}  // namespace nav::sim
