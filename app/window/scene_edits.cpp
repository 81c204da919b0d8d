// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/scene_edits.hpp"

#include <algorithm>
#include <tuple>

#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

bool asks_for_needle(const render::PredicateModel& model, const VoxelGrid& grid) {
  return std::ranges::any_of(kinds_of(model), [&](const std::string& name) {
    const auto kind = render::find_predicate_kind(name);
    return kind && (*kind)->needs({grid, {}, {}, {}}).needle;
  });
}

}  // namespace

bool operator==(const CutawayEdit& a, const CutawayEdit& b) {
  return std::tie(a.on, a.theta1_rad, a.theta2_rad, a.overlay_mm) ==
         std::tie(b.on, b.theta1_rad, b.theta2_rad, b.overlay_mm);
}

void apply_edits_to(const SceneEdits& edits, render::Scene& scene) {
  if (edits.predicates) {
    const render::PredicateVolume& volume = *edits.predicates;
    render::PredicateScene predicates = volume.predicates;
    predicates.needle_lost =
        !scene.needle && asks_for_needle(predicates.model, volume.ultrasound->grid());
    if (scene.predicates) {
      scene.ct = volume.ultrasound;
      scene.predicates = std::move(predicates);
    } else if (scene.ultrasound) {
      scene.ultrasound->volume = volume.ultrasound;
      scene.ultrasound->predicates = std::move(predicates);
    }
  }
  constexpr double kFaint = 0.5;
  const Eigen::Vector3d violet(0.75, 0.45, 1.0);
  for (const auto& one : edits.structures) {
    scene.spheres.push_back({one.centre_ct, one.radius_mm, violet, kFaint});
  }
  if (edits.transfer) scene.transfer = *edits.transfer;
  if (edits.emphasis) scene.shading.emphasis = *edits.emphasis;
  if (edits.style) scene.shading.style = *edits.style;
  if (!edits.cutaway) return;
  if (!edits.cutaway->on) {
    scene.cutaway.reset();
    return;
  }
  if (!scene.cutaway) scene.cutaway.emplace();
  scene.cutaway->theta1_rad = edits.cutaway->theta1_rad;
  scene.cutaway->theta2_rad = std::max(edits.cutaway->theta1_rad, edits.cutaway->theta2_rad);
  scene.cutaway->overlay_mm = edits.cutaway->overlay_mm;
}

}  // namespace nav::app
