// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_predicate_painter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace nav::render {
namespace {

constexpr int kPredicateBlock = 8;     // Pixels; a multiple of the packet's sides.
constexpr int kPredicateTile = 32;     // Pixels; a multiple of a block's side.
constexpr double kSampleInCell = 0.5;  // Post-classified: the middle of the cell.

}  // namespace

struct CpuPredicatePainter::Packet : CpuPacket {
  PredicateRays more;
  PixelRecord seen[kPacketLanes];  ///< The ultrasound image: column, row.
  bool finished[kPacketLanes];     ///< No later sample may be visible; only beside a CT.
};

/// Light that is composited besides the volume's own samples.
struct CpuPredicatePainter::Light {
  spec::Rgb<float> rgb;
  float alpha;
  float importance;  ///< In the units of PredicateAppearance.
  float image;       ///< Share of the ultrasound image in the colour.
};

/// Working data of a tile.
struct CpuPredicatePainter::Tile {
  Tile(const CutObjects& objects, const CpuCtBeside* beside) : all(objects), some(objects) {
    if (beside != nullptr) ct.emplace(*beside);
  }

  CutSelection all;
  CutSelection some;
  Packet packet{};
  std::optional<CpuCtBeside::Packet> ct{};
  MarchCounts counts{};
  std::uint64_t rays = 0;
  std::uint64_t cut_rays = 0;
};

CpuPredicatePainter::CpuPredicatePainter(const Scene& scene, const CpuPredicates& predicates,
                                         const CpuMarches& marches, const CutPlan& cutaway,
                                         const CutawayField* field, CpuImage& image,
                                         const Beside& beside)
    : scene_(scene),
      cutaway_(cutaway),
      image_(image),
      in_(predicates.inputs(scene)),
      how_(predicates.blend()),
      surface_importance_(predicates.greatest()),
      initial_importance_(predicates.initial()),
      beside_(beside),
      ct_importance_(predicates.of_impact(beside.importance)),
      rays_of_(scene, marches.rays, cutaway, field, kSampleInCell, in_.base.overlay_cells),
      tiles_across_((scene.width + kPredicateTile - 1) / kPredicateTile),
      tiles_down_((scene.height + kPredicateTile - 1) / kPredicateTile) {
  const bool shades = scene.predicates->shading.has_value();
  plain_ = marches.predicates.march(how_, false, shades);
  fading_ = marches.predicates.march(how_, true, shades);
}

void CpuPredicatePainter::paint_tile(int index) {
  const int x0 = index % tiles_across_ * kPredicateTile;
  const int y0 = index / tiles_across_ * kPredicateTile;
  Tile tile(cutaway_.objects(), beside_.ct);
  for (int by = y0; by < std::min(y0 + kPredicateTile, scene_.height); by += kPredicateBlock) {
    for (int bx = x0; bx < std::min(x0 + kPredicateTile, scene_.width); bx += kPredicateBlock) {
      const bool solids = rays_of_.solids(bx, by, kPredicateBlock);
      const bool cut = rays_of_.cuts() && rays_of_.cull(bx, by, kPredicateBlock, tile.all.choice(),
                                                        tile.some.choice());
      if (tile.ct) beside_.ct->enter(bx, by, kPredicateBlock, *tile.ct);
      for (int y = by; y < std::min(by + kPredicateBlock, scene_.height); y += kPacketHeight) {
        for (int x = bx; x < std::min(bx + kPredicateBlock, scene_.width); x += kPacketWidth) {
          paint_packet(x, y, solids, cut, tile);
        }
      }
    }
  }
  rays_ += tile.rays;
  samples_ += tile.counts.samples;
  passed_ += tile.counts.passed;
  gradients_ += tile.counts.gradients;
  faded_ += tile.counts.faded;
  cutaway_rays_ += tile.cut_rays;
}

void CpuPredicatePainter::paint_packet(int x0, int y0, bool solids, bool cut, Tile& tile) const {
  Packet& p = tile.packet;
  rays_of_.start(x0, y0, solids, cut ? &tile.some.choice() : nullptr, p);
  std::fill_n(p.seen, kPacketLanes, PixelRecord{});
  std::fill_n(p.more.image, kPacketLanes, 0.0F);
  std::fill_n(p.more.importance, kPacketLanes, initial_importance_);
  std::fill_n(p.more.left_out, kPacketLanes, 0.0F);
  std::fill_n(p.finished, kPacketLanes, false);
  tile.cut_rays += static_cast<std::uint64_t>(p.cut);
  if (tile.ct) beside_.ct->start(x0, y0, *tile.ct);
  composite(tile);
  tile.rays += store_packet(p);
}

RenderStatistics CpuPredicatePainter::statistics() const {
  RenderStatistics statistics;
  statistics.rays = rays_;
  statistics.volume_samples = samples_;
  statistics.passed_samples = passed_;
  statistics.gradient_samples = gradients_;
  statistics.cutaway_rays = cutaway_rays_;
  statistics.faded_cells = faded_;
  return statistics;
}

void CpuPredicatePainter::composite(Tile& tile) const {
  Packet& p = tile.packet;
  const PredicateMarch march = p.cut > 0 ? fading_ : plain_;
  for (std::size_t segment = 0; segment <= p.most_hits; ++segment) {
    if (tile.ct) {
      march_both(segment, tile);
    } else if (p.starts.any) {
      if (p.most_hits > 0) rays_of_.set_segment(segment, p);
      march(in_, p.rays, p.more, tile.counts);
    }
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      if (segment < p.hits[lane].size()) blend(p.hits[lane][segment], lane, p);
    }
  }
}

// All lanes take the same slab at the same time, so that they agree on the order in depth.
void CpuPredicatePainter::march_both(std::size_t segment, Tile& tile) const {
  Packet& p = tile.packet;
  const RayStarts& ct = tile.ct->rays.starts;
  const double slab = beside_.ct->slab_mm();
  LaneStretches before;
  LaneStretches both;
  LaneStretches after;
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    auto whole = between_surfaces(p.hits[lane], segment);
    if (p.finished[lane]) whole.end = whole.begin;
    double begin = std::max({whole.begin, p.starts.begin[lane], ct.begin[lane]});
    double end = std::min({whole.end, p.starts.end[lane], ct.end[lane]});
    if (end > begin) {
      first = std::min(first, std::floor(begin / slab));
      last = std::max(last, std::ceil(end / slab));
    } else {  // One volume ends before the other begins.
      const bool two = p.starts.end[lane] > p.starts.begin[lane] && ct.end[lane] > ct.begin[lane];
      const double turn = two ? std::min(p.starts.end[lane], ct.end[lane]) : whole.begin;
      begin = end = std::clamp(turn, whole.begin, std::max(whole.begin, whole.end));
    }
    before.begin[lane] = whole.begin;
    before.end[lane] = both.begin[lane] = begin;
    both.end[lane] = after.begin[lane] = end;
    after.end[lane] = whole.end;
  }
  march_slab(before, true, tile);
  for (double m = first; m < last; m += 1) {
    if (close_finished(p)) return;
    LaneStretches part;
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      part.begin[lane] = std::max(m * slab, both.begin[lane]);
      part.end[lane] =
          p.finished[lane] ? part.begin[lane] : std::min((m + 1) * slab, both.end[lane]);
    }
    march_slab(part, std::fmod(m, 2) == 0, tile);
  }
  if (close_finished(p)) return;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (p.finished[lane]) after.end[lane] = after.begin[lane];
  }
  march_slab(after, true, tile);
}

void CpuPredicatePainter::march_slab(const LaneStretches& stretches, bool ct_first,
                                     Tile& tile) const {
  if (!ct_first) march_ultrasound(stretches, tile);
  march_ct(stretches, tile);
  if (ct_first) march_ultrasound(stretches, tile);
}

void CpuPredicatePainter::march_ultrasound(const LaneStretches& stretches, Tile& tile) const {
  Packet& p = tile.packet;
  if (!p.starts.any || !rays_of_.set_stretches(stretches, p)) return;
  (p.cut > 0 ? fading_ : plain_)(in_, p.rays, p.more, tile.counts);
}

void CpuPredicatePainter::march_ct(const LaneStretches& stretches, Tile& tile) const {
  if (!beside_.ct->march(stretches, *tile.ct, tile.counts)) return;
  const RayPacket& ct = tile.ct->rays.rays;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const float alpha = ct.alpha[lane];
    if (!(alpha > 0)) continue;
    const spec::Rgb<float> rgb(ct.rgb[0][lane], ct.rgb[1][lane], ct.rgb[2][lane]);
    put({rgb / alpha, alpha, ct_importance_, 0}, lane, tile.packet);
  }
}

// Rule 2 of EarlyEnds with the greatest importance of all as the one to come. True: all lanes are
// finished.
bool CpuPredicatePainter::close_finished(Packet& p) const {
  const auto enough = static_cast<float>(1 - beside_.termination_error);
  bool all = true;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    float kept = p.rays.alpha[lane];
    if (how_ == PredicateBlend::kWeight) kept *= std::min(1.0F, p.more.importance[lane]);
    if (how_ == PredicateBlend::kLog) {
      kept *= std::exp(-std::max(0.0F, surface_importance_ - p.more.importance[lane]));
    }
    p.finished[lane] = p.finished[lane] || (beside_.termination_error > 0 && kept >= enough);
    all = all && p.finished[lane];
  }
  return all;
}

void CpuPredicatePainter::blend(const spec::Hit<double>& hit, int lane, Packet& p) const {
  if (p.finished[lane]) return;
  // The colour of the ultrasound image is added later; until then only its share is known.
  put({hit.image ? spec::Rgb<float>::Zero() : spec::Rgb<float>(hit.rgb.cast<float>()),
       static_cast<float>(hit.alpha), surface_importance_, hit.image ? 1.0F : 0.0F},
      lane, p);
  if (!hit.image) return;
  p.seen[lane].column = static_cast<float>(hit.pixel.x());
  p.seen[lane].row = static_cast<float>(hit.pixel.y());
}

void CpuPredicatePainter::put(const Light& light, int lane, Packet& p) const {
  spec::ImportanceState<float> state{
      {p.rays.rgb[0][lane], p.rays.rgb[1][lane], p.rays.rgb[2][lane]},
      p.rays.alpha[lane],
      p.more.importance[lane]};
  const float beta = how_ == PredicateBlend::kOver
                         ? spec::composite_over(state, light.rgb, light.alpha)
                     : how_ == PredicateBlend::kWeight
                         ? spec::composite_weight(state, light.rgb, light.alpha, light.importance)
                         : spec::composite_log(state, light.rgb, light.alpha, light.importance);
  p.more.image[lane] += beta * (light.image - p.more.image[lane]);
  for (int c = 0; c < 3; ++c) p.rays.rgb[c][lane] = state.rgb[c];
  p.rays.alpha[lane] = state.alpha;
  p.more.importance[lane] = state.importance;
}

std::uint64_t CpuPredicatePainter::store_packet(const Packet& p) const {
  std::uint64_t rays = 0;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!inside(p.pixels.x[lane], p.pixels.y[lane])) continue;
    store(lane, p);
    ++rays;
  }
  return rays;
}

void CpuPredicatePainter::store(int lane, const Packet& p) const {
  PixelRecord& record = image_.at(p.pixels.x[lane], p.pixels.y[lane]);
  record = p.seen[lane];
  const float alpha = p.rays.alpha[lane];
  record.weight = alpha * p.more.image[lane];
  record.signature = 0;  // No ray of another painter has this signature.
  for (int c = 0; c < 3; ++c) {
    record.base[c] =
        alpha * p.rays.rgb[c][lane] + (1 - alpha) * static_cast<float>(scene_.background_rgb[c]);
  }
}

}  // namespace nav::render
