// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/surfaces.hpp"

#include <algorithm>

namespace nav::render {

Surfaces::Surfaces(const Scene& scene) : shading_(scene.shading) {
  const VoxelGrid& grid = scene.ct->grid();
  if (scene.plane) plane_ = spec::make_plane<double>(*scene.plane, grid);
  if (scene.needle) needle_ = spec::make_needle<double>(*scene.needle, grid);
  for (const SphereShape& s : scene.spheres) solids_.push_back(spec::make_sphere<double>(s, grid));
  for (const LineShape& l : scene.lines) solids_.push_back(spec::make_line<double>(l, grid));
}

void Surfaces::meet(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const {
  hits.clear();
  const auto add = [&](const std::optional<spec::Hit<double>>& hit) {
    if (hit) hits.push_back(*hit);
  };
  if (plane_) add(spec::hit_plane(*plane_, ray));
  if (needle_) add(spec::hit_capsule(*needle_, ray, shading_));
  for (const auto& solid : solids_) add(spec::hit_capsule(solid, ray, shading_));
  // Insertion sort: stable without allocating, and there are few.
  for (std::size_t i = 1; i < hits.size(); ++i) {
    for (std::size_t j = i; j > 0 && hits[j].t < hits[j - 1].t; --j)
      std::swap(hits[j], hits[j - 1]);
  }
  const auto opaque =
      std::find_if(hits.begin(), hits.end(), [](const auto& hit) { return hit.alpha >= 1; });
  if (opaque != hits.end()) hits.erase(opaque + 1, hits.end());
}

}  // namespace nav::render
