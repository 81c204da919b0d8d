// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "render/cpu_march.hpp"
#include "render/cpu_picture.hpp"
#include "render/cutaway_mesh.hpp"
#include "render/engine.hpp"
#include "render/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {

/// What cuts the rays of a picture.
struct CpuCutaway {
  spec::CutawayObjects<double> objects;  ///< Everything, unless there is a field.
  const CutawayField* field = nullptr;   ///< With large meshes: everything.
  [[nodiscard]] bool empty() const { return objects.empty() && field == nullptr; }
};

/// Draws tiles of one picture. Thread-safe: each tile keeps its state on its own stack.
class CpuPainter {
 public:
  /// All must outlive it. cutaway: empty when key.fade is off. keep: rays of the records that meet
  /// the same as before keep their pixels; only for records of the same view.
  CpuPainter(const Scene& scene, const MarchInputs& in, const MarchKey& key,
             const MarchSet& marches, const CpuCutaway& cutaway, CpuPicture& picture, bool keep);

  [[nodiscard]] int tiles() const { return tiles_across_ * tiles_down_; }
  void paint_tile(int tile);
  /// What it cost; call when every tile is painted.
  [[nodiscard]] RenderStatistics statistics() const;

 private:
  struct Packet;

  void start_packet(int x0, int y0, Packet& p);
  void start_lane(int x, int y, int lane, Packet& p) const;
  [[nodiscard]] spec::CutawaySpan<double> span_of(int x, int y, const spec::Ray<double>& ray) const;
  void cut_lane(int x, int y, const spec::Ray<double>& ray, int lane, Packet& p) const;
  void composite(Packet& p, MarchCounts& counts) const;
  void project(Packet& p, MarchCounts& counts) const;
  void set_segment(std::size_t segment, Packet& p) const;
  void blend(const spec::Hit<double>& hit, int lane, Packet& p) const;
  [[nodiscard]] bool inside(int x, int y) const { return x < scene_.width && y < scene_.height; }
  [[nodiscard]] bool unchanged(int x0, int y0, const Packet& p) const;
  void store(int x, int y, int lane, const Packet& p) const;

  const Scene& scene_;
  const MarchInputs& in_;
  const CpuCutaway& cutaway_;
  CpuPicture& picture_;
  bool keep_;
  March plain_;
  March fading_;
  March project_;
  Surfaces surfaces_;
  spec::View<double> view_;
  double step_;
  double first_sample_;  ///< Where sample 0 lies in cell 0, in cells.
  int tiles_across_;
  int tiles_down_;
  std::atomic<std::uint64_t> rays_{0};
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> gradients_{0};
  std::atomic<std::uint64_t> window_gradients_{0};
  std::atomic<std::uint64_t> cutaway_rays_{0};
  std::atomic<std::uint64_t> faded_{0};
};

}  // namespace nav::render
