// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "nav/volume.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/tissue.hpp"

namespace nav::sim {

struct PhantomOptions {
  std::uint64_t seed = 1;  ///< Each seed gives another patient: organs, vessels, lesion, ribs.
  Contrast contrast = Contrast::kPortal;
};

/// One segment of a vessel tree: a cylinder with round ends, CT coordinates.
struct VesselSegment {
  Point<frames::Ct> from;
  Point<frames::Ct> to;
  double radius_mm;
  Tissue tissue;  ///< kHepaticVein or kPortalVein (lumen).
  int parent;     ///< Index in vessels() of the segment it branches from; -1 for a trunk.
};

/// Analytic abdomen in CT coordinates (LPS, mm: +x left, +y posterior, +z superior; the liver is at
/// negative x). Every tissue is a signed distance, so the truth is known at every point. About 285
/// mm wide, 200 mm deep, infinite along z; the organs lie within |z| < 110 mm. Copies share the
/// anatomy. Reading is thread-safe.
class AbdomenPhantom final : public Anatomy {
 public:
  explicit AbdomenPhantom(const PhantomOptions& options = {});
  ~AbdomenPhantom() override;
  AbdomenPhantom(const AbdomenPhantom&);
  AbdomenPhantom& operator=(const AbdomenPhantom&);

  [[nodiscard]] const PhantomOptions& options() const;
  [[nodiscard]] std::string name() const override;
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>& p) const override;
  /// Boundaries are blended over about 1 mm.
  [[nodiscard]] double hu(const Point<frames::Ct>& p) const override;
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Point<frames::Ct>& p) const override;
  /// Boundaries are blended over 0.8 mm.
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>& p) const override;
  /// Result of tissue() without the acceleration grid, for tests of the grid: all organs are
  /// evaluated. Slow.
  [[nodiscard]] Tissue tissue_exhaustive(const Point<frames::Ct>& p) const;
  /// Exact within 10 % near the skin.
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const override;
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override;
  /// Distance to the liver surface, mm, negative inside; exact within 10 % near the surface.
  [[nodiscard]] double liver_distance_mm(const Point<frames::Ct>& p) const;
  /// Point on the skin. \p angle_rad: rotation about +z in the x-y plane; pi is the right flank, 3
  /// pi / 2 the front.
  [[nodiscard]] Point<frames::Ct> skin_point(double angle_rad, double z_mm) const;

  [[nodiscard]] const std::vector<VesselSegment>& vessels() const;
  /// Straight path from the skin to the lesion that avoids ribs, lung, gallbladder and vessels with
  /// a radius above 2 mm.
  [[nodiscard]] NeedlePlan plan() const;
  /// At least six anatomical points.
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override;
  /// At least 100 points, distributed evenly in the liver.
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override;

 private:
  struct Body;
  std::shared_ptr<const Body> body_;
};

}  // namespace nav::sim
