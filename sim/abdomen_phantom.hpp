// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "nav/volume.hpp"
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

struct NamedPoint {
  std::string name;
  Point<frames::Ct> position_ct;
};

/// Analytic abdomen in CT coordinates (LPS, mm: +x left, +y posterior, +z superior; the liver is at
/// negative x). Every tissue is a signed distance, so truth is known at every point. About 285 mm
/// wide, 200 mm deep, endless along z; organs lie within |z| < 110 mm. Copies share the anatomy;
/// thread-safe to read.
class AbdomenPhantom {
 public:
  explicit AbdomenPhantom(const PhantomOptions& options = {});
  ~AbdomenPhantom();
  AbdomenPhantom(const AbdomenPhantom&);
  AbdomenPhantom& operator=(const AbdomenPhantom&);

  [[nodiscard]] const PhantomOptions& options() const;
  /// Tissue that fills a point.
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>& p) const;
  /// CT value without noise, HU; boundaries are blended over about 1 mm (partial volume).
  [[nodiscard]] double hu(const Point<frames::Ct>& p) const;
  /// Acoustic values, boundaries blended over 0.8 mm.
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>& p) const;
  /// Same as tissue(), asking every organ: the oracle of the acceleration grid. Slow.
  [[nodiscard]] Tissue tissue_exhaustive(const Point<frames::Ct>& p) const;
  /// Distance to the skin surface, mm; negative inside the patient. Exact within 10 % near it.
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>& p) const;
  /// Distance to the liver surface, mm, negative inside; same accuracy.
  [[nodiscard]] double liver_distance_mm(const Point<frames::Ct>& p) const;
  /// Point of the skin. angle_rad turns about +z in the x-y plane: pi is the right flank,
  /// 3 pi / 2 the front.
  [[nodiscard]] Point<frames::Ct> skin_point(double angle_rad, double z_mm) const;

  [[nodiscard]] const std::vector<VesselSegment>& vessels() const;
  /// Straight path from the skin to the lesion that keeps off ribs, lung, gallbladder and vessels
  /// of more than 2 mm radius.
  [[nodiscard]] NeedlePlan plan() const;
  /// Anatomical points that a person can find again in both pictures; at least six.
  [[nodiscard]] std::vector<NamedPoint> landmarks() const;
  /// At least 100 points spread evenly in the liver: where target registration error is counted.
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const;

 private:
  struct Anatomy;
  std::shared_ptr<const Anatomy> anatomy_;
};

}  // namespace nav::sim
