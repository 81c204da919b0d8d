// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "nav/plan.hpp"
#include "sim/random.hpp"
#include "sim/shapes.hpp"
#include "sim/tissue.hpp"

/// How the phantom's organs are laid out. Private to sim/. CT coordinates, mm.
namespace nav::sim {

using Distance = std::function<double(const Eigen::Vector3d&)>;

/// One shape of one tissue. Later organs of a list cover earlier ones.
struct Organ {
  Tissue tissue;
  Distance distance_mm;
  Eigen::AlignedBox3d bounds;  ///< Holds every point with distance below 2 mm.
};

/// Numbers that differ between patients.
struct Build {
  shapes::SuperEllipse body{142, 100};
  shapes::Ellipsoid right_dome, left_dome;
  shapes::Ellipsoid right_lobe, left_lobe, visceral;
  shapes::Ellipsoid right_kidney, left_kidney, gallbladder;
  double fat_mm = 9;
  double wave_phase[4] = {};
  double spine_phase_mm = 0;

  explicit Build(std::uint64_t seed);
  [[nodiscard]] double fat_thickness_mm(const Eigen::Vector3d& p) const;
  [[nodiscard]] double wall_thickness_mm(const Eigen::Vector3d& p) const;
  /// Inside the abdominal and chest wall.
  [[nodiscard]] double cavity_mm(const Eigen::Vector3d& p) const;
  /// Below the diaphragm.
  [[nodiscard]] double abdomen_mm(const Eigen::Vector3d& p) const;
  [[nodiscard]] double liver_mm(const Eigen::Vector3d& p) const;
};

/// Box in which the organs' surfaces lie.
Eigen::AlignedBox3d anatomy_bounds();

/// Wall layers, soft organs, spine, ribs, lung; not lesion and liver vessels.
void add_body_wall(const Build& build, std::vector<Organ>& organs);
void add_digestive(const Build& build, Random& random, std::vector<Organ>& organs);
void add_kidneys(const Build& build, Random& random, std::vector<Organ>& organs);
void add_liver(const Build& build, std::vector<Organ>& organs);
void add_great_vessels(std::vector<Organ>& organs);
void add_thorax(const Build& build, std::vector<Organ>& organs);
void add_spine(const Build& build, std::vector<Organ>& organs);
void add_ribs(const Build& build, Random& random, std::vector<Organ>& organs);

/// A lesion and a path to it that keeps off bone, cartilage, lung, gas and gallbladder. A Bug when
/// no place in the liver has one.
NeedlePlan choose_plan(const Build& build, const std::vector<Organ>& organs, Random& random);

/// Sample points of a box, low discrepancy (Halton 2, 3, 5), index from 1.
Eigen::Vector3d halton_in(const Eigen::AlignedBox3d& box, int index);

}  // namespace nav::sim
