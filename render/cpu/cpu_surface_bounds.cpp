// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_surface_bounds.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace nav::render {

SurfaceBounds::SurfaceBounds(const Scene& scene) : origin_(scene.ct->grid().origin_mm) {
  if (scene.plane && scene.plane->safety.state != SafetyState::kLost) {
    const UltrasoundImage& frame = scene.plane->frame;
    std::vector<Eigen::Vector3d> corners;
    for (const double x : {-0.5, frame.pixels.width() - 0.5}) {
      for (const double y : {-0.5, frame.pixels.height() - 0.5}) {
        const Eigen::Vector2d p =
            frame.grid.origin_mm + frame.grid.mm_per_pixel * Eigen::Vector2d(x, y);
        const Point<frames::Image> image{{p.x(), p.y(), 0}};
        corners.push_back((scene.plane->ct_from_image * image).mm);
      }
    }
    Eigen::Vector3d centre(0, 0, 0);
    for (const Eigen::Vector3d& p : corners) centre += p / static_cast<double>(corners.size());
    double reach = 0;
    for (const Eigen::Vector3d& p : corners) reach = std::max(reach, (p - centre).norm());
    add(centre, centre, reach);
    first_shape_ = 1;
  }
  if (scene.needle && scene.needle->safety.state != SafetyState::kLost) {
    add(scene.needle->tip_ct.mm, scene.needle->hub_ct.mm, scene.needle->radius_mm);
  }
  for (const SphereShape& s : scene.spheres) add(s.centre_ct.mm, s.centre_ct.mm, s.radius_mm);
  for (const LineShape& l : scene.lines) add(l.from_ct.mm, l.to_ct.mm, l.radius_mm);
}

void SurfaceBounds::add(const Eigen::Vector3d& from_ct, const Eigen::Vector3d& to_ct,
                        double radius_mm) {
  constexpr double kSlackMm = 1e-3;  // Covers the rounding of distant positions.
  capsules_.push_back({from_ct - origin_, to_ct - origin_, radius_mm * 1.0001 + kSlackMm});
}

SurfaceReach SurfaceBounds::reach(const spec::View<double>& view, int x0, int y0, int size) const {
  const auto middle = spec::ray_of(view, x0 + size / 2, y0 + size / 2);
  // The first corner is the pixel centre that is farthest from that of the ray.
  const auto corner = spec::ray_of(view, x0, y0);
  const double spread = 1.01 * (corner.direction - middle.direction).norm();
  const double shift = 1.01 * (corner.origin - middle.origin).norm();
  const auto aside = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d to = point - middle.origin;
    return Eigen::Vector3d(to - to.dot(middle.direction) * middle.direction);
  };
  const auto reached = [&](const Capsule& capsule) {
    const Eigen::Vector3d from = aside(capsule.from);
    const Eigen::Vector3d along = aside(capsule.to) - from;
    const double length = along.squaredNorm();
    const double nearest = length > 0 ? std::clamp(-from.dot(along) / length, 0.0, 1.0) : 0.0;
    const double farthest =
        std::max((capsule.from - middle.origin).norm(), (capsule.to - middle.origin).norm());
    // A point q on another ray is at most |q| sin(angle) from this one; 2 bounds wide angles.
    const double turn = 2 * spread * (farthest + capsule.radius);
    return (from + nearest * along).norm() <= capsule.radius + turn + shift;
  };
  const auto shapes = capsules_.begin() + first_shape_;
  return {std::any_of(capsules_.begin(), shapes, reached),
          std::any_of(shapes, capsules_.end(), reached)};
}

}  // namespace nav::render
