// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "render/cpu/cpu_cutaway_plan.hpp"
#include "render/cpu/cpu_march.hpp"
#include "render/cpu/cpu_surface_bounds.hpp"
#include "render/cutaway_mesh.hpp"
#include "render/skipping/visible_spans.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {

/// The value that RayStart gives t1 and t2 of rays that the cutaway does not meet.
inline constexpr double kCutNowhere = -1e30;

/// The interval between the surfaces segment - 1 and segment of a ray, mm; empty behind an opaque
/// surface.
spec::Interval<double> between_surfaces(const std::vector<spec::Hit<double>>& hits,
                                        std::size_t segment);

/// The packet of the block of pixels that begins at (x0, y0).
PacketPixels block_pixels(int x0, int y0);

/// A packet of rays and everything that they meet besides the volume.
struct CpuPacket {
  RayPacket rays;
  PacketPixels pixels;
  VisibleSpan spans[kPacketLanes];
  RayStarts starts;
  std::vector<spec::Hit<double>> hits[kPacketLanes];
  std::size_t most_hits;
  int cut;  ///< Number of lanes that the cutaway meets within the box.
  CutRays cut_rays;
  double foot[kPacketLanes];  ///< Distance to the foot of the cutaway's reference point on the ray,
                              ///< mm.
  float from[kPacketLanes];   ///< Whole cells in front of this, and from `until` on, show nothing.
  float until[kPacketLanes];
};

/// An interval of every lane's ray, mm; empty when end <= begin.
struct LaneStretches {
  double begin[kPacketLanes];
  double end[kPacketLanes];
};

/// The rays of one image up to the volume, for every painter: their parts in the volume, the
/// surfaces that they meet, and their cuts by the cutaway. Thread-safe: packets hold all state.
class CpuRays {
 public:
  /// All arguments must outlive it. \p field: null, or with large meshes all objects that cut,
  /// instead of cutaway. \p first_sample: position of sample 0 in its cell, in cells.
  /// \p overlay_cells: see MarchInputs.
  CpuRays(const Scene& scene, const MarchSet& marches, const CutPlan& cutaway,
          const CutawayField* field, double first_sample, float overlay_cells);

  [[nodiscard]] bool cuts() const { return !cutaway_.empty(); }
  /// Keeps the objects that may cut a ray of a square of pixels. False when no cut reaches the
  /// volume.
  [[nodiscard]] bool cull(int x0, int y0, int size, const CutChoice& from, CutChoice& to) const;
  /// Surfaces that any ray of a square of pixels may meet.
  [[nodiscard]] SurfaceReach reach(int x0, int y0, int size) const {
    return surfaces_.empty() ? SurfaceReach{} : bounds_.reach(view_, x0, y0, size);
  }
  /// True when any ray of a square of pixels may meet a surface.
  [[nodiscard]] bool solids(int x0, int y0, int size) const { return reach(x0, y0, size).any(); }
  /// True when the ray of a pixel meets the border of the ultrasound image.
  [[nodiscard]] bool meets_border(int x, int y) const {
    return surfaces_.meets_border(spec::ray_of(view_, x, y));
  }
  /// Starts the packet of the block of pixels that begins at (x0, y0). \p choice: null if nothing
  /// cuts.
  void start(int x0, int y0, bool solids, const CutChoice* choice, CpuPacket& p) const {
    start(x0, y0, {solids, solids}, choice, {}, p);
  }
  /// Starts the packet. The rays keep only the cells that may lie partly in the span.
  void start(int x0, int y0, const SurfaceReach& reach, const CutChoice* choice,
             const VisibleSpan& span, CpuPacket& p) const;
  /// Starts the packet of p.pixels with p.spans.
  void start(const SurfaceReach& reach, const CutChoice* choice, CpuPacket& p) const;
  /// Limits every lane to the interval between its surfaces segment - 1 and segment.
  void set_segment(std::size_t segment, CpuPacket& p) const;
  /// Limits every lane to the part of its interval in the volume. False when all of them are empty.
  bool set_stretches(const LaneStretches& stretches, CpuPacket& p) const;

 private:
  void keep_spans(CpuPacket& p) const;
  void meet_surfaces(const SurfaceReach& reach, CpuPacket& p) const;
  void cut(const CutChoice& choice, CpuPacket& p) const;
  void cut_by_field(CpuPacket& p) const;
  bool set_lane(double begin_mm, double end_mm, int lane, CpuPacket& p) const;
  void cut_lane(double t1_mm, double t2_mm, int lane, CpuPacket& p) const;

  MarchSet marches_;
  const CutPlan& cutaway_;
  const CutawayField* field_;
  Surfaces surfaces_;
  spec::View<double> view_;
  CutView cut_view_;
  SurfaceBounds bounds_;
  double step_;  ///< mm.
  RayInputs inputs_;
  double near_mm_;        ///< No ray enters the volume in front of this distance.
  double overlay_cells_;  ///< 0 for infinity.
};

}  // namespace nav::render
