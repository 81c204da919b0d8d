// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/render/predicates/predicate_scenes.hpp"

/// Scenes with a CT and an ultrasound volume.
namespace nav::test {

/// Ultrasound with all samples visible and equal: grey without hue.
inline render::UltrasoundVolume grey_ultrasound(const VoxelGrid& grid, double value,
                                                double opacity_length_mm) {
  render::UltrasoundVolume out;
  out.volume = make_volume(grid, [value](int, int, int) { return value; });
  out.predicates.model = model_of({{render::PredicateExpression::kind("intensity", {0, 1}), 1}}, 0);
  out.predicates.opacity_length_mm = opacity_length_mm;
  out.predicates.termination_error = 0;
  return out;
}

/// Fog in a box of 30 mm, with ultrasound in the given grid.
inline render::Scene fog_scene(const VoxelGrid& where, double tau_per_mm) {
  const VoxelGrid grid = centred_grid({31, 31, 31}, {1, 1, 1});
  const auto ct = make_volume(grid, [](int, int, int) { return 0; });
  render::Scene scene = plain_scene(ct, fog(tau_per_mm, {1, 0.5, 0.25}), frontal(100, 12, true));
  scene.ultrasound = grey_ultrasound(where, 102, 2);
  return scene;
}

inline constexpr double kGrey = 0.4;  // Grey of the value 102.

inline double grey_tau() { return -std::log(1 - kGrey) / 2; }

/// A random scene by predicates as the second volume of a scene with a CT.
inline render::Scene random_two(std::mt19937& random, int i) {
  std::uniform_real_distribution<double> unit(0, 1);
  const VoxelGrid grid = centred_grid(
      {19, 17, 15}, {0.8, 0.7, 0.9},
      Eigen::AngleAxisd(0.4 * i, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix());
  const auto us = small_ultrasound(grid, static_cast<unsigned>(i));
  render::Scene scene =
      random_predicate_scene(random, us, random_features(us, static_cast<unsigned>(i)));
  scene.ultrasound =
      render::UltrasoundVolume{us, *scene.predicates, i % 3 == 0 ? 1024 : 2 * unit(random)};
  scene.ultrasound->predicates.termination_error = 0;
  scene.predicates.reset();
  scene.quality.opaque_at = 1;
  scene.shading.enabled = i % 2 == 0;
  scene.transfer = *render::preset_transfer_function("ct-bone");
  scene.ct = make_volume(centred_grid({25, 23, 21}, {1.3, 1.1, 1.2}), [&](int a, int b, int c) {
    return 200 + 150 * std::sin(0.5 * a + 0.3 * b) + 100 * std::cos(c);
  });
  return scene;
}

/// Returns a copy of the scene with the CT at another position.
inline render::Scene moved_ct(render::Scene scene, const Eigen::Vector3d& by_mm) {
  VoxelGrid grid = scene.ct->grid();
  grid.origin_mm += by_mm;
  const auto hu = scene.ct->values();
  scene.ct = std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, {hu.begin(), hu.end()}, "moved"));
  return scene;
}

}  // namespace nav::test
