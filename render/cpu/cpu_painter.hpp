// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "render/cpu/cpu_image.hpp"
#include "render/cpu/cpu_lattice.hpp"
#include "render/cpu/cpu_rays.hpp"
#include "render/engine.hpp"
#include "render/quality/sparse_rays.hpp"

namespace nav::render {

/// Draws tiles of one image. Thread-safe: each tile keeps its state on its own stack.
class CpuPainter {
 public:
  /// All arguments must outlive it. \p cutaway: empty when key.fade is off. \p field: null, or with
  /// large meshes all objects that cut, instead of cutaway. \p keep: rays that meet the same
  /// objects as those in the records of \p image keep their pixels; only for records of the same
  /// view.
  CpuPainter(const Scene& scene, const MarchInputs& in, const MarchKey& key,
             const MarchSet& marches, const CutPlan& cutaway, const CutawayField* field,
             CpuImage& image, bool keep, const VisibleSpans* spans,
             const std::optional<SparseRays>& sparse);

  [[nodiscard]] int tiles() const { return tiles_across_ * tiles_down_; }
  /// 1, or more with sparse rays.
  [[nodiscard]] int passes() const { return lattice_ ? lattice_->passes() : 1; }
  /// Paints a tile. All tiles of a pass must be painted before the next pass.
  void paint_tile(int tile, int pass);
  /// Statistics of the work done. Call it when every tile is painted.
  [[nodiscard]] RenderStatistics statistics() const;

 private:
  struct Packet;
  struct Tile;

  void paint_block(int x0, int y0, int pass, Tile& tile);
  void cast_all(int x0, int y0, const SurfaceReach& reach, const VisibleSpan& span, Tile& tile);
  void halve_squares(int x0, int y0, int pass, const SurfaceReach& reach, const VisibleSpan& span,
                     Tile& tile);
  void add_lattice(int x0, int y0, const VisibleSpan& span, Tile& tile);
  void add_pixel(int x, int y, const VisibleSpan& span, Tile& tile);
  void paint_added(Tile& tile);
  void paint_packet(Tile& tile);
  std::uint64_t leave_empty(int x0, int y0) const;
  void composite(Packet& p, MarchCounts& counts) const;
  void project(Packet& p, MarchCounts& counts) const;
  void blend(const spec::Hit<double>& hit, int lane, Packet& p) const;
  [[nodiscard]] bool inside(int x, int y) const { return x < scene_.width && y < scene_.height; }
  [[nodiscard]] bool unchanged(const Packet& p) const;
  std::uint64_t store_packet(const Packet& p) const;
  void store(int lane, const Packet& p) const;

  const Scene& scene_;
  const MarchInputs& in_;
  const CutPlan& cutaway_;
  CpuImage& image_;
  bool keep_;
  const VisibleSpans* spans_;
  std::optional<SparseRays> sparse_;
  std::optional<PixelLattice> lattice_;  ///< Present with sparse_.
  March plain_;
  March fading_;
  March project_;
  CpuRays rays_of_;
  int tiles_across_;
  int tiles_down_;
  std::atomic<std::uint64_t> rays_{0};
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> passed_{0};
  std::atomic<std::uint64_t> gradients_{0};
  std::atomic<std::uint64_t> window_gradients_{0};
  std::atomic<std::uint64_t> cutaway_rays_{0};
  std::atomic<std::uint64_t> faded_{0};
  std::atomic<std::uint64_t> means_{0};
};

}  // namespace nav::render
