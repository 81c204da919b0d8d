// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "render/cpu_cutaway_plan.hpp"
#include "render/cpu_march.hpp"
#include "render/cpu_surface_bounds.hpp"
#include "render/engine.hpp"
#include "render/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {

/// Draws tiles of one picture. Thread-safe: each tile keeps its state on its own stack.
class CpuPainter {
 public:
  /// All must outlive it. cutaway: empty when key.fade is off.
  CpuPainter(const Scene& scene, const MarchInputs& in, const MarchKey& key,
             const MarchSet& marches, const CutPlan& cutaway);

  [[nodiscard]] int tiles() const { return tiles_across_ * tiles_down_; }
  void paint_tile(int tile);
  /// The picture; call once, when every tile is painted.
  RenderedImage finish();

 private:
  struct Packet;
  struct Tile;

  void paint_block(int x0, int y0, Tile& tile);
  /// False: the cutaway reaches no ray of a block in the volume.
  bool cull(int x0, int y0, int size, const CutChoice& from, CutChoice& to) const;
  void start_packet(int x0, int y0, Packet& p) const;
  void meet_surfaces(int x0, int y0, Packet& p) const;
  void cut_packet(int x0, int y0, const CutChoice& choice, Packet& p) const;
  void cut_lane(double t1_mm, double t2_mm, int lane, Packet& p) const;
  void composite(Packet& p, MarchCounts& counts) const;
  void project(Packet& p, MarchCounts& counts) const;
  void set_segment(std::size_t segment, Packet& p) const;
  void blend(const spec::Hit<double>& hit, int lane, RayPacket& rays) const;
  void store(int x, int y, int lane, const RayPacket& rays);

  const Scene& scene_;
  const MarchInputs& in_;
  const CutPlan& cutaway_;
  March plain_;
  March fading_;
  March project_;
  CutCull cull_;
  CutMeet meet_;
  CutAim aim_;
  Surfaces surfaces_;
  spec::View<double> view_;
  CutView cut_view_;
  SurfaceBounds bounds_;
  double step_;
  RayStart start_;
  RayInputs ray_inputs_;
  double near_mm_;  ///< No ray enters the volume before.
  int tiles_across_;
  int tiles_down_;
  std::vector<RgbaF> pixels_;
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> gradients_{0};
  std::atomic<std::uint64_t> window_gradients_{0};
  std::atomic<std::uint64_t> cutaway_rays_{0};
  std::atomic<std::uint64_t> faded_{0};
};

}  // namespace nav::render
