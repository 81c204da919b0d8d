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
  std::uint64_t seed = 1;  ///< Another seed, another patient: organs, vessels, lesion, ribs.
  Contrast contrast = Contrast::kPortal;
};

/// One piece of a vessel tree: a cylinder with round ends, CT coordinates.
struct VesselSegment {
  Point<frames::Ct> from;
  Point<frames::Ct> to;
  double radius_mm;
  Tissue tissue;  ///< kHepaticVein or kPortalVein (lumen).
  int parent;     ///< Index in vessels() of the piece it grows from; -1 for a trunk.
};

/// Analytic abdomen in CT coordinates (LPS, mm: +x left, +y posterior, +z superior; the liver is at
/// negative x). Every tissue is a signed distance, so truth is known at every point. About 285 mm
/// wide, 200 mm deep, endless along z; organs lie within |z| < 110 mm. Copies share the anatomy;
/// thread-safe to read.
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
  /// Same as tissue(), asking every organ: the oracle of the acceleration grid. Slow.
  [[nodiscard]] Tissue tissue_exhaustive(const Point<frames::Ct>& p) const;
  /// Exact within 10 % near the skin.
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const override;
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override;
  /// Distance to the liver surface, mm, negative inside; same accuracy.
  [[nodiscard]] double liver_distance_mm(const Point<frames::Ct>& p) const;
  /// Point of the skin. angle_rad turns about +z in the x-y plane: pi is the right flank,
  /// 3 pi / 2 the front.
  [[nodiscard]] Point<frames::Ct> skin_point(double angle_rad, double z_mm) const;

  [[nodiscard]] const std::vector<VesselSegment>& vessels() const;
  /// Straight path from the skin to the lesion that keeps off ribs, lung, gallbladder and vessels
  /// of more than 2 mm radius.
  [[nodiscard]] NeedlePlan plan() const;
  /// At least six.
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override;
  /// At least 100 points spread evenly in the liver.
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override;

 private:
  struct Body;
  std::shared_ptr<const Body> body_;
};

}  // namespace nav::sim
