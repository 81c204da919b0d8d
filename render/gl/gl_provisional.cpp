// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Images by predicates from some of the voxels while the rest is being sent.
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <chrono>

#include "render/gl/gl_raycaster.hpp"
#include "render/scene_compare.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {

Result<void> GlRaycaster::draw_fitted(const Scene& scene, const std::optional<SharedDepth>& depth,
                                      SceneChange change) {
  if (!cast_) return whole_.textures.update(scene);
  auto lacking = set_lacking(scene);
  if (!lacking) return lacking.error();
  if (!*lacking) {
    release_coarse();
    return cast(scene, depth, change == SceneChange::kGeometry);
  }
  statistics_.provisional = true;
  const PredicateSet& set = **lacking;
  // The first image must appear soon, so it does not wait for data.
  if (provisional_) {
    const Features& offered = scene.predicates->features;
    if (auto ok = whole_.predicates.send_some(set, offered, bytes_a_image_); !ok) return ok;
    // Until there is more to show, the same image is not drawn again.
    cast_ = depth || change_between(*provisional_, scene) != SceneChange::kNothing;
    if (!cast_) return {};
  }
  provisional_.reset();
  if (auto ok = cast_coarse(scene, set, depth); !ok) return ok;
  provisional_ = scene;
  return {};
}

Result<std::optional<PredicateSet>> GlRaycaster::set_lacking(const Scene& scene) const {
  std::optional<PredicateSet> lacking;
  const bool may_be = scene.quality.provisional && drawn_by_predicates(scene);
  // A new volume must be sent in any case.
  if (!may_be || !whole_.textures.has(scene.ct)) return lacking;
  auto set = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
  if (!set) return set.error();
  const std::size_t bytes = whole_.predicates.missing_bytes(*set, scene.predicates->features);
  if (bytes > bytes_a_image_) lacking = *std::move(set);
  return lacking;
}

Result<void> GlRaycaster::cast_coarse(const Scene& scene, const PredicateSet& set,
                                      const std::optional<SharedDepth>& depth) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const Scene coarse = coarse_volumes_.of(scene, set);
  const std::chrono::duration<double> halving = Clock::now() - start;
  if (!coarse_) coarse_.emplace();
  source_ = &*coarse_;
  auto ok = cast(coarse, depth, false);
  statistics_.prepare_s += halving.count();
  return ok;
}

void GlRaycaster::release_coarse() {
  source_ = &whole_;
  coarse_.reset();
  coarse_volumes_.release();
  provisional_.reset();
}

}  // namespace nav::render
