// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_ct_beside.hpp"

#include <algorithm>

#include "render/two_volumes.hpp"

namespace nav::render {

CpuCtBeside::CpuCtBeside(const Scene& scene, const MarchInputs& in, const MarchKey& key,
                         const MarchSet& marches, const CutPlan& cutaway, const CutawayField* field)
    : in_(in),
      cutaway_(cutaway),
      plain_(marches.composite({key.classify, key.shade, false, key.cells})),
      fading_(key.fade ? marches.composite(key) : plain_),
      rays_of_(scene, marches, cutaway, field,
               key.classify == MarchClassify::kPreIntegrated ? 0.0 : 0.5, in.overlay_cells),
      slab_mm_(render::slab_mm(scene)) {}

void CpuCtBeside::enter(int x0, int y0, int size, Packet& p) const {
  p.cut = rays_of_.cuts() && rays_of_.cull(x0, y0, size, p.all.choice(), p.some.choice());
}

void CpuCtBeside::start(int x0, int y0, Packet& p) const {
  rays_of_.start(x0, y0, false, p.cut ? &p.some.choice() : nullptr, p.rays);
}

bool CpuCtBeside::march(const LaneStretches& stretches, Packet& p, MarchCounts& counts) const {
  if (!p.rays.starts.any || !rays_of_.set_stretches(stretches, p.rays)) return false;
  RayPacket& rays = p.rays.rays;
  for (auto& channel : rays.rgb) std::fill_n(channel, kPacketLanes, 0.0F);
  std::fill_n(rays.alpha, kPacketLanes, 0.0F);
  (p.rays.cut > 0 ? fading_ : plain_)(in_, rays, counts);
  return true;
}

}  // namespace nav::render
