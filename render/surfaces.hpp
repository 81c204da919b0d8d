// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// Which surfaces rays may meet.
struct SurfaceReach {
  bool plane;   ///< The ultrasound picture.
  bool shapes;  ///< Needle, spheres, lines.

  [[nodiscard]] bool any() const { return plane || shapes; }
  [[nodiscard]] SurfaceReach with(const SurfaceReach& other) const {
    return {plane || other.plane, shapes || other.shapes};
  }
};

/// Everything of a scene that is not the volume, ready to meet rays. The scene must outlive it.
/// Thread-safe to read.
class Surfaces {
 public:
  explicit Surfaces(const Scene& scene);
  [[nodiscard]] bool empty() const { return !plane_ && !needle_ && solids_.empty(); }
  /// Fills hits with what a ray (local mm) meets, nearest first, ending with the first opaque one.
  void meet(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const;
  /// The same where a ray can meet no others than these, without the grey of the ultrasound
  /// picture.
  void meet(const spec::Ray<double>& ray, const SurfaceReach& reach,
            std::vector<spec::Hit<double>>& hits) const;
  /// Whether a ray meets the border of the ultrasound picture, be it behind something else.
  [[nodiscard]] bool meets_border(const spec::Ray<double>& ray) const;

 private:
  /// Adds what is met besides the ultrasound picture, and sorts.
  void meet_shapes(const spec::Ray<double>& ray, std::vector<spec::Hit<double>>& hits) const;

  Shading shading_;
  spec::View<double> view_;
  std::optional<spec::PlaneSurface<double>> plane_;
  std::optional<spec::CapsuleSurface<double>> needle_;
  std::vector<spec::CapsuleSurface<double>> solids_;
};

}  // namespace nav::render
