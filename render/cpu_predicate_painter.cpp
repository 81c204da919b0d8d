// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_predicate_painter.hpp"

#include <algorithm>

namespace nav::render {
namespace {

constexpr int kBlock = 8;              // Pixels; a multiple of the packet's sides.
constexpr int kTile = 32;              // Pixels; a multiple of a block's side.
constexpr double kSampleInCell = 0.5;  // Post-classified: the middle.

}  // namespace

struct CpuPredicatePainter::Packet : CpuPacket {
  PredicateRays more;
  PixelRecord seen[kPacketLanes];  ///< The ultrasound picture: column, row.
};

/// What a tile works with.
struct CpuPredicatePainter::Tile {
  explicit Tile(const CutObjects& objects) : all(objects), some(objects) {}

  CutSelection all;
  CutSelection some;
  Packet packet{};
  MarchCounts counts{};
  std::uint64_t rays = 0;
  std::uint64_t cut_rays = 0;
};

CpuPredicatePainter::CpuPredicatePainter(const Scene& scene, const CpuPredicates& predicates,
                                         bool vector, const CutPlan& cutaway,
                                         const CutawayField* field, CpuPicture& picture)
    : scene_(scene),
      cutaway_(cutaway),
      picture_(picture),
      in_(predicates.inputs(scene)),
      how_(predicates.blend()),
      surface_importance_(predicates.greatest()),
      initial_importance_(predicates.initial()),
      rays_of_(scene, vector ? vector_marches() : portable_marches(), cutaway, field, kSampleInCell,
               in_.base.overlay_cells),
      tiles_across_((scene.width + kTile - 1) / kTile),
      tiles_down_((scene.height + kTile - 1) / kTile) {
  const PredicateMarchSet marches =
      vector ? avx2_predicate_marches() : portable_predicate_marches();
  plain_ = marches.march(how_, false);
  fading_ = marches.march(how_, true);
}

void CpuPredicatePainter::paint_tile(int index) {
  const int x0 = index % tiles_across_ * kTile;
  const int y0 = index / tiles_across_ * kTile;
  Tile tile(cutaway_.objects());
  for (int by = y0; by < std::min(y0 + kTile, scene_.height); by += kBlock) {
    for (int bx = x0; bx < std::min(x0 + kTile, scene_.width); bx += kBlock) {
      const bool solids = rays_of_.solids(bx, by, kBlock);
      const bool cut =
          rays_of_.cuts() && rays_of_.cull(bx, by, kBlock, tile.all.choice(), tile.some.choice());
      for (int y = by; y < std::min(by + kBlock, scene_.height); y += kPacketHeight) {
        for (int x = bx; x < std::min(bx + kBlock, scene_.width); x += kPacketWidth) {
          paint_packet(x, y, solids, cut, tile);
        }
      }
    }
  }
  rays_ += tile.rays;
  samples_ += tile.counts.samples;
  faded_ += tile.counts.faded;
  cutaway_rays_ += tile.cut_rays;
}

void CpuPredicatePainter::paint_packet(int x0, int y0, bool solids, bool cut, Tile& tile) const {
  Packet& p = tile.packet;
  rays_of_.start(x0, y0, solids, cut ? &tile.some.choice() : nullptr, p);
  std::fill_n(p.seen, kPacketLanes, PixelRecord{});
  std::fill_n(p.more.picture, kPacketLanes, 0.0F);
  std::fill_n(p.more.importance, kPacketLanes, initial_importance_);
  std::fill_n(p.more.left_out, kPacketLanes, 0.0F);
  tile.cut_rays += static_cast<std::uint64_t>(p.cut);
  composite(p, tile.counts);
  tile.rays += store_packet(x0, y0, p);
}

RenderStatistics CpuPredicatePainter::statistics() const {
  RenderStatistics statistics;
  statistics.rays = rays_;
  statistics.volume_samples = samples_;
  statistics.cutaway_rays = cutaway_rays_;
  statistics.faded_cells = faded_;
  return statistics;
}

void CpuPredicatePainter::composite(Packet& p, MarchCounts& counts) const {
  const PredicateMarch march = p.cut > 0 ? fading_ : plain_;
  for (std::size_t segment = 0; segment <= p.most_hits; ++segment) {
    if (p.starts.any) {
      if (p.most_hits > 0) rays_of_.set_segment(segment, p);
      march(in_, p.rays, p.more, counts);
    }
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      if (segment < p.hits[lane].size()) blend(p.hits[lane][segment], lane, p);
    }
  }
}

// The colour of the ultrasound picture is put in later: until then only its share is known.
void CpuPredicatePainter::blend(const spec::Hit<double>& hit, int lane, Packet& p) const {
  spec::ImportanceState<float> state{
      {p.rays.rgb[0][lane], p.rays.rgb[1][lane], p.rays.rgb[2][lane]},
      p.rays.alpha[lane],
      p.more.importance[lane]};
  const spec::Rgb<float> rgb =
      hit.picture ? spec::Rgb<float>::Zero() : spec::Rgb<float>(hit.rgb.cast<float>());
  const auto alpha = static_cast<float>(hit.alpha);
  const float beta = how_ == PredicateBlend::kOver ? spec::composite_over(state, rgb, alpha)
                     : how_ == PredicateBlend::kWeight
                         ? spec::composite_weight(state, rgb, alpha, surface_importance_)
                         : spec::composite_log(state, rgb, alpha, surface_importance_);
  p.more.picture[lane] += beta * ((hit.picture ? 1.0F : 0.0F) - p.more.picture[lane]);
  for (int c = 0; c < 3; ++c) p.rays.rgb[c][lane] = state.rgb[c];
  p.rays.alpha[lane] = state.alpha;
  p.more.importance[lane] = state.importance;
  if (!hit.picture) return;
  p.seen[lane].column = static_cast<float>(hit.pixel.x());
  p.seen[lane].row = static_cast<float>(hit.pixel.y());
}

std::uint64_t CpuPredicatePainter::store_packet(int x0, int y0, const Packet& p) const {
  std::uint64_t rays = 0;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const int x = x0 + lane % kPacketWidth;
    const int y = y0 + lane / kPacketWidth;
    if (!inside(x, y)) continue;
    store(x, y, lane, p);
    ++rays;
  }
  return rays;
}

void CpuPredicatePainter::store(int x, int y, int lane, const Packet& p) const {
  PixelRecord& record = picture_.at(x, y);
  record = p.seen[lane];
  const float alpha = p.rays.alpha[lane];
  record.weight = alpha * p.more.picture[lane];
  record.signature = 0;  // Of no other painter's rays.
  for (int c = 0; c < 3; ++c) {
    record.base[c] =
        alpha * p.rays.rgb[c][lane] + (1 - alpha) * static_cast<float>(scene_.background_rgb[c]);
  }
}

}  // namespace nav::render
