// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_predicate_painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/cpu_inputs.hpp"

namespace nav::render {
namespace {

constexpr int kBlock = 8;              // Pixels; a multiple of the packet's sides.
constexpr int kTile = 32;              // Pixels; a multiple of a block's side.
constexpr double kNowhere = -1e30;     // As RayStart sets t1 and t2.
constexpr double kSampleInCell = 0.5;  // Post-classified: the middle.

}  // namespace

struct CpuPredicatePainter::Packet {
  RayPacket rays;
  PredicateRays more;
  RayStarts starts;
  std::vector<spec::Hit<double>> hits[kPacketLanes];
  std::size_t most_hits;
  int cut;                         ///< Lanes that the cutaway meets within the box.
  PixelRecord seen[kPacketLanes];  ///< The ultrasound picture: column, row.
  CutRays cut_rays;
  double foot[kPacketLanes];  ///< Of the cutaway's reference point on the ray, mm.
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
      field_(field),
      picture_(picture),
      in_(predicates.inputs(scene)),
      how_(predicates.blend()),
      surface_importance_(predicates.greatest()),
      initial_importance_(predicates.initial()),
      rays_of_(vector ? vector_marches() : portable_marches()),
      surfaces_(scene),
      view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
      cut_view_(cut_view(view_, cutaway.centre())),
      bounds_(scene),
      step_(spec::step_mm(scene.quality, scene.ct->grid())),
      ray_inputs_(ray_inputs(scene, kSampleInCell)),
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
      const bool solids = !surfaces_.empty() && bounds_.reach(view_, bx, by, kBlock);
      const bool cut = !cutaway_.empty() && cull(bx, by, tile.all.choice(), tile.some.choice());
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

bool CpuPredicatePainter::cull(int x0, int y0, const CutChoice& from, CutChoice& to) const {
  const CutBlock block = cut_block(view_, cutaway_.centre(), x0, y0, kBlock);
  const double most = rays_of_.cull(cutaway_.objects(), block, from, to);
  // The foot of another ray may lie farther by the turn and the shift.
  const double to_centre = (cutaway_.centre() - view_.eye).norm();
  return most + block.foot + block.angle * to_centre + block.shift > 0;
}

void CpuPredicatePainter::paint_packet(int x0, int y0, bool solids, bool cut, Tile& tile) const {
  Packet& p = tile.packet;
  rays_of_.start(ray_inputs_, x0, y0, p.rays, p.starts);
  p.most_hits = 0;
  p.cut = 0;
  std::fill_n(p.seen, kPacketLanes, PixelRecord{});
  std::fill_n(p.more.picture, kPacketLanes, 0.0F);
  std::fill_n(p.more.importance, kPacketLanes, initial_importance_);
  for (auto& hits : p.hits) hits.clear();
  if (solids) meet_surfaces(x0, y0, p);
  if (cut && p.starts.any) cut_packet(x0, y0, tile.some.choice(), p);
  if (field_ != nullptr && p.starts.any) cut_by_field(x0, y0, p);
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

void CpuPredicatePainter::meet_surfaces(int x0, int y0, Packet& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    surfaces_.meet(spec::ray_of(view_, x0 + lane % kPacketWidth, y0 + lane / kPacketWidth),
                   p.hits[lane]);
    p.most_hits = std::max(p.most_hits, p.hits[lane].size());
  }
}

void CpuPredicatePainter::cut_packet(int x0, int y0, const CutChoice& choice, Packet& p) const {
  rays_of_.aim(ray_inputs_, cut_view_, x0, y0, p.cut_rays, p.foot);
  rays_of_.meet(cutaway_.objects(), choice, p.cut_rays);
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    cut_lane(p.foot[lane] + static_cast<double>(p.cut_rays.t1[lane]),
             p.foot[lane] + static_cast<double>(p.cut_rays.t2[lane]), lane, p);
  }
}

void CpuPredicatePainter::cut_by_field(int x0, int y0, Packet& p) const {
  std::array<spec::CutawaySpan<float>, kPacketLanes> spans{};
  for (int row = 0; row < kPacketHeight; ++row) {
    field_->meet_row(view_, x0, y0 + row, kPacketWidth, spans.data() + row * kPacketWidth);
  }
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    const spec::CutawaySpan<float>& span = spans[static_cast<std::size_t>(lane)];
    cut_lane(span.t1, span.t2, lane, p);
  }
}

void CpuPredicatePainter::cut_lane(double t1_mm, double t2_mm, int lane, Packet& p) const {
  if (!(t2_mm > p.starts.begin[lane])) return;
  const double t2 = t2_mm / step_ - p.starts.base[lane];
  const double t1 = std::max(t1_mm / step_ - p.starts.base[lane], kNowhere);
  p.rays.t2[lane] = static_cast<float>(t2);
  p.rays.t1[lane] = static_cast<float>(t1);
  p.rays.per_transition[lane] = static_cast<float>(std::min(1 / (t2 - t1), -kNowhere));
  ++p.cut;
}

void CpuPredicatePainter::composite(Packet& p, MarchCounts& counts) const {
  const PredicateMarch march = p.cut > 0 ? fading_ : plain_;
  for (std::size_t segment = 0; segment <= p.most_hits; ++segment) {
    if (p.starts.any) {
      if (p.most_hits > 0) set_segment(segment, p);
      march(in_, p.rays, p.more, counts);
    }
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      if (segment < p.hits[lane].size()) blend(p.hits[lane][segment], lane, p);
    }
  }
}

// The stretch between the surfaces segment - 1 and segment of every lane.
void CpuPredicatePainter::set_segment(std::size_t segment, Packet& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const auto& hits = p.hits[lane];
    double begin = p.starts.begin[lane];
    double end = p.starts.end[lane];
    if (segment > 0 && segment <= hits.size()) begin = std::max(begin, hits[segment - 1].t);
    if (segment < hits.size()) end = std::min(end, hits[segment].t);
    const bool past =
        segment > hits.size() || (segment == hits.size() && segment > 0 && hits.back().alpha >= 1);
    if (past || !(end > begin)) {
      p.rays.begin[lane] = p.rays.end[lane] = 0;
      continue;
    }
    p.rays.begin[lane] = static_cast<float>(begin / step_ - p.starts.base[lane]);
    p.rays.end[lane] = static_cast<float>(end / step_ - p.starts.base[lane]);
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
