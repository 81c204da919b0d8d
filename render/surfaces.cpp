// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/surfaces.hpp"

#include <algorithm>

namespace nav::render {
namespace {

void add_hit(const std::optional<spec::Hit<double>>& hit, std::vector<spec::Hit<double>>& hits) {
  if (hit) hits.push_back(*hit);
}

}  // namespace

Surfaces::Surfaces(const Scene& scene)
    : shading_(scene.shading),
      view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())) {
  const VoxelGrid& grid = scene.ct->grid();
  if (scene.plane) plane_ = spec::make_plane<double>(*scene.plane, grid);
  if (scene.needle) needle_ = spec::make_needle<double>(*scene.needle, grid);
  for (const SphereShape& s : scene.spheres) solids_.push_back(spec::make_sphere<double>(s, grid));
  for (const LineShape& l : scene.lines) solids_.push_back(spec::make_line<double>(l, grid));
}

void Surfaces::meet(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const {
  hits.clear();
  if (plane_) add_hit(spec::hit_plane(*plane_, view_, ray), hits);
  meet_shapes(ray, hits);
}

void Surfaces::meet(const spec::Ray<double>& ray, const SurfaceReach& reach,
                    std::vector<spec::Hit<double>>& hits) const {
  hits.clear();
  if (plane_ && reach.plane) add_hit(spec::reach_plane(*plane_, view_, ray), hits);
  if (reach.shapes) meet_shapes(ray, hits);
}

bool Surfaces::meets_border(const spec::Ray<double>& ray) const {
  if (!plane_) return false;
  const auto hit = spec::reach_plane(*plane_, view_, ray);
  return hit && !hit->image;
}

void Surfaces::meet_shapes(const spec::Ray<double>& ray,
                           std::vector<spec::Hit<double>>& hits) const {
  if (needle_) add_hit(spec::hit_capsule(*needle_, ray, shading_), hits);
  for (const auto& solid : solids_) add_hit(spec::hit_capsule(solid, ray, shading_), hits);
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
