// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "render/cpu/cpu_ct_beside.hpp"
#include "render/cpu/cpu_image.hpp"
#include "render/cpu/cpu_marches.hpp"
#include "render/cpu/cpu_predicates.hpp"
#include "render/cpu/cpu_rays.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// Draws tiles of one image whose volume is classified by predicates. Every ray is cast, because
/// the visible colour of a surface in front depends on everything behind it. Thread-safe: each tile
/// keeps its state on its own stack.
class CpuPredicatePainter {
 public:
  /// A CT in which the volume lies.
  struct Beside {
    const CpuCtBeside* ct = nullptr;  ///< Null: no CT.
    double importance = 1;            ///< Impact of the CT.
    double termination_error = 0;     ///< The ray ends when at most this may still change.
  };
  /// All arguments except the marches must outlive it. \p beside: with a CT, the scene's own
  /// termination error must be 0, because its bricks do not know the later samples of the CT.
  CpuPredicatePainter(const Scene& scene, const CpuPredicates& predicates,
                      const CpuMarches& marches, const CutPlan& cutaway, const CutawayField* field,
                      CpuImage& image, const Beside& beside);

  [[nodiscard]] int tiles() const { return tiles_across_ * tiles_down_; }
  void paint_tile(int tile);
  /// Statistics of the work done. Call it when every tile is painted.
  [[nodiscard]] RenderStatistics statistics() const;

 private:
  struct Packet;
  struct Tile;

  void paint_packet(int x0, int y0, bool solids, bool cut, Tile& tile) const;
  void composite(Tile& tile) const;
  void march_both(std::size_t segment, Tile& tile) const;
  void march_slab(const LaneStretches& stretches, bool ct_first, Tile& tile) const;
  void march_ultrasound(const LaneStretches& stretches, Tile& tile) const;
  void march_ct(const LaneStretches& stretches, Tile& tile) const;
  bool close_finished(Packet& p) const;
  void blend(const spec::Hit<double>& hit, int lane, Packet& p) const;
  struct Light;
  void put(const Light& light, int lane, Packet& p) const;
  [[nodiscard]] std::uint64_t store_packet(const Packet& p) const;
  void store(int lane, const Packet& p) const;
  [[nodiscard]] bool inside(int x, int y) const { return x < scene_.width && y < scene_.height; }

  const Scene& scene_;
  const CutPlan& cutaway_;
  CpuImage& image_;
  PredicateInputs in_;
  PredicateBlend how_;
  float surface_importance_;
  float initial_importance_;
  Beside beside_;
  float ct_importance_;
  PredicateMarch plain_;
  PredicateMarch fading_;
  CpuRays rays_of_;
  int tiles_across_;
  int tiles_down_;
  std::atomic<std::uint64_t> rays_{0};
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> passed_{0};
  std::atomic<std::uint64_t> gradients_{0};
  std::atomic<std::uint64_t> cutaway_rays_{0};
  std::atomic<std::uint64_t> faded_{0};
};

}  // namespace nav::render
