// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// The surfaces that rays may meet.
struct SurfaceReach {
  bool plane;   ///< The ultrasound image.
  bool shapes;  ///< Needle, spheres, lines.

  [[nodiscard]] bool any() const { return plane || shapes; }
  [[nodiscard]] SurfaceReach with(const SurfaceReach& other) const {
    return {plane || other.plane, shapes || other.shapes};
  }
};

/// All surfaces of a scene, that is everything but the volume, ready to meet rays. The scene must
/// outlive it. Thread-safe to read.
class Surfaces {
 public:
  explicit Surfaces(const Scene& scene);
  [[nodiscard]] bool empty() const { return !plane_ && !needle_ && solids_.empty(); }
  /// Fills hits with what a ray (local mm) meets, nearest first, up to the first opaque one.
  void meet(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const;
  /// Does the same for a ray that can meet only the surfaces in reach, without the grey of the
  /// ultrasound image.
  void meet(const spec::Ray<double>& ray, const SurfaceReach& reach,
            std::vector<spec::Hit<double>>& hits) const;
  /// True if a ray meets the border of the ultrasound image, even behind something else.
  [[nodiscard]] bool meets_border(const spec::Ray<double>& ray) const;

 private:
  /// Adds everything but the ultrasound image, and sorts.
  void meet_shapes(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const;

  Shading shading_;
  spec::View<double> view_;
  std::optional<spec::PlaneSurface<double>> plane_;
  std::optional<spec::CapsuleSurface<double>> needle_;
  std::vector<spec::CapsuleSurface<double>> solids_;
};

}  // namespace nav::render
