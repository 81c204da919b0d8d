// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_cutaway_plan.hpp"
#include "render/cpu/cpu_rays.hpp"

namespace nav::render {

/// The CT of a scene with two volumes. It is marched interval by interval for the painter of the
/// ultrasound volume: ray_spec.hpp, "Two volumes". Thread-safe, because packets hold all state.
class CpuCtBeside {
 public:
  /// All arguments must outlive it; see CpuPainter. Precondition: the scene has an ultrasound
  /// volume.
  CpuCtBeside(const Scene& scene, const MarchInputs& in, const MarchKey& key,
              const MarchSet& marches, const CutPlan& cutaway, const CutawayField* field);

  /// A packet of the CT's rays.
  struct Packet {
    explicit Packet(const CpuCtBeside& ct)
        : all(ct.cutaway_.objects()), some(ct.cutaway_.objects()) {}
    CutSelection all;
    CutSelection some;
    bool cut = false;  ///< The cutaway may reach a ray of the square.
    CpuPacket rays{};  ///< Without surfaces. Colour and opacity are those of the last march().
  };
  /// Call it before the packets of a square of pixels.
  void enter(int x0, int y0, int size, Packet& p) const;
  void start(int x0, int y0, Packet& p) const;
  /// Composites the CT in the intervals, separately from the other volume. False when no interval
  /// lies in the CT.
  bool march(const LaneStretches& stretches, Packet& p, MarchCounts& counts) const;

  [[nodiscard]] double slab_mm() const { return slab_mm_; }

 private:
  const MarchInputs& in_;
  const CutPlan& cutaway_;
  March plain_;
  March fading_;
  CpuRays rays_of_;
  double slab_mm_;
};

}  // namespace nav::render
