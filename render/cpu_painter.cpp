// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "render/cpu_inputs.hpp"

namespace nav::render {
namespace {

constexpr int kBlock = 8;  // Pixels; a multiple of the packet's sides.
constexpr int kTile = 32;  // Pixels; a multiple of a block's side.

constexpr double kNowhere = -1e30;  // As RayStart sets t1 and t2.

static_assert(spec::kFadeSteps == 4, "kMarchFadeSteps of cpu_kernel_classify.hpp");
static_assert(spec::kGoochBlue == 0.4 && spec::kGoochYellow == 0.4, "cpu_kernel_shade.hpp");
static_assert(spec::kSilhouettePower == 4, "cpu_kernel_shade.hpp");

MarchProject project_of(Projection projection) {
  switch (projection) {
    case Projection::kMinimum:
      return MarchProject::kMinimum;
    case Projection::kMean:
      return MarchProject::kMean;
    case Projection::kMaximum:
    case Projection::kComposite:
      break;
  }
  return MarchProject::kMaximum;
}

/// Mixes the bits of a number into a hash.
template <class T>
void add_bits(std::uint64_t& hash, T value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  hash = (hash ^ bits) * 0x9E3779B97F4A7C15U;
  hash ^= hash >> 32;
}

/// Of everything that a ray meets besides the volume; the grey of an ultrasound picture is put in
/// later. Never 0, which no ray has.
std::uint64_t signature_of(const std::vector<spec::Hit<double>>& hits, float t1, float t2,
                           float overlay) {
  std::uint64_t hash = 1;
  if (t2 > static_cast<float>(kNowhere)) {
    add_bits(hash, t1);
    add_bits(hash, t2);
    add_bits(hash, overlay);
  }
  for (const spec::Hit<double>& hit : hits) {
    add_bits(hash, hit.t);
    add_bits(hash, hit.alpha);
    add_bits(hash, hit.picture);
    const double values[3] = {hit.picture ? hit.pixel.x() : hit.rgb.x(),
                              hit.picture ? hit.pixel.y() : hit.rgb.y(),
                              hit.picture ? 0 : hit.rgb.z()};
    for (const double value : values) add_bits(hash, value);
  }
  return hash == 0 ? 1 : hash;
}

/// A distance before which no ray of a view meets the volume, mm: by the ball around it.
double nearest_mm(const spec::View<double>& view, const VoxelGrid& grid) {
  const Eigen::Vector3d to = grid.centre().mm - grid.origin_mm - view.eye;
  const double along = view.orthographic ? to.dot(view.forward) : to.norm();
  // A voxel more, for axes that have but one.
  return std::max(0.0, along - 0.5 * grid.extent_mm().norm() - grid.spacing_mm.norm());
}

}  // namespace

struct CpuPainter::Packet {
  RayPacket rays;
  RayStarts starts;
  std::vector<spec::Hit<double>> hits[kPacketLanes];
  std::size_t most_hits;
  int cut;  ///< Lanes that the cutaway meets within the box.
  std::uint64_t signature[kPacketLanes];
  PixelRecord seen[kPacketLanes];  ///< The ultrasound picture: weight, column, row.
  CutRays cut_rays;
  double foot[kPacketLanes];  ///< Of the cutaway's reference point on the ray, mm.
};

/// What a tile works with.
struct CpuPainter::Tile {
  explicit Tile(const CutObjects& objects) : all(objects), tile(objects), block(objects) {}

  CutSelection all;
  CutSelection tile;
  CutSelection block;
  bool cut = false;     ///< The cutaway may reach some ray.
  bool solids = false;  ///< And so may a surface.
  Packet packet{};
  MarchCounts counts{};
  std::uint64_t rays = 0;
  std::uint64_t cut_rays = 0;
};

CpuPainter::CpuPainter(const Scene& scene, const MarchInputs& in, const MarchKey& key,
                       const MarchSet& marches, const CutPlan& cutaway, const CutawayField* field,
                       CpuPicture& picture, bool keep)
    : scene_(scene),
      in_(in),
      cutaway_(cutaway),
      field_(field),
      picture_(picture),
      keep_(keep),
      plain_(marches.composite({key.classify, key.shade, false})),
      fading_(key.fade ? marches.composite(key) : plain_),
      project_(marches.project(project_of(scene.projection))),
      cull_(marches.cull),
      meet_(marches.meet),
      aim_(marches.aim),
      surfaces_(scene),
      view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
      cut_view_(cut_view(view_, cutaway.centre())),
      bounds_(scene),
      step_(spec::step_mm(scene.quality, scene.ct->grid())),
      start_(marches.start),
      ray_inputs_(ray_inputs(scene, key.classify == MarchClassify::kPreIntegrated &&
                                            scene.projection == Projection::kComposite
                                        ? 0.0
                                        : 0.5)),
      near_mm_(nearest_mm(view_, scene.ct->grid())),
      tiles_across_((scene.width + kTile - 1) / kTile),
      tiles_down_((scene.height + kTile - 1) / kTile) {}

void CpuPainter::paint_tile(int index) {
  const int x0 = index % tiles_across_ * kTile;
  const int y0 = index / tiles_across_ * kTile;
  Tile tile(cutaway_.objects());
  tile.cut = !cutaway_.empty() && cull(x0, y0, kTile, tile.all.choice(), tile.tile.choice());
  for (int y = y0; y < std::min(y0 + kTile, scene_.height); y += kBlock) {
    for (int x = x0; x < std::min(x0 + kTile, scene_.width); x += kBlock) paint_block(x, y, tile);
  }
  rays_ += tile.rays;
  samples_ += tile.counts.samples;
  gradients_ += tile.counts.gradients;
  window_gradients_ += tile.counts.window_gradients;
  faded_ += tile.counts.faded;
  cutaway_rays_ += tile.cut_rays;
}

bool CpuPainter::cull(int x0, int y0, int size, const CutChoice& from, CutChoice& to) const {
  const CutBlock block = cut_block(view_, cutaway_.centre(), x0, y0, size);
  const double most = cull_(cutaway_.objects(), block, from, to);
  // The foot of another ray may lie farther by the turn and the shift.
  const double to_centre = (cutaway_.centre() - view_.eye).norm();
  return most + block.foot + block.angle * to_centre + block.shift > near_mm_;
}

void CpuPainter::paint_block(int x0, int y0, Tile& tile) {
  tile.solids = !surfaces_.empty() && bounds_.reach(view_, x0, y0, kBlock);
  const bool cut = tile.cut && cull(x0, y0, kBlock, tile.tile.choice(), tile.block.choice());
  Packet& p = tile.packet;
  for (int y = y0; y < std::min(y0 + kBlock, scene_.height); y += kPacketHeight) {
    for (int x = x0; x < std::min(x0 + kBlock, scene_.width); x += kPacketWidth) {
      start_packet(x, y, p);
      for (auto& hits : p.hits) hits.clear();
      std::fill_n(p.seen, kPacketLanes, PixelRecord{});
      if (tile.solids) meet_surfaces(x, y, p);
      if (cut && p.starts.any) cut_packet(x, y, tile.block.choice(), p);
      if (field_ != nullptr && p.starts.any) cut_by_field(x, y, p);
      for (int lane = 0; lane < kPacketLanes; ++lane) {
        p.signature[lane] =
            signature_of(p.hits[lane], p.rays.t1[lane], p.rays.t2[lane], in_.overlay_cells);
      }
      if (keep_ && unchanged(x, y, p)) continue;
      tile.cut_rays += static_cast<std::uint64_t>(p.cut);
      if (scene_.projection == Projection::kComposite) {
        composite(p, tile.counts);
      } else {
        project(p, tile.counts);
      }
      tile.rays += store_packet(x, y, p);
    }
  }
}

RenderStatistics CpuPainter::statistics() const {
  RenderStatistics statistics;
  statistics.rays = rays_;
  statistics.volume_samples = samples_;
  statistics.gradient_samples = gradients_;
  statistics.window_gradients = window_gradients_;
  statistics.cutaway_rays = cutaway_rays_;
  statistics.faded_cells = faded_;
  return statistics;
}

bool CpuPainter::unchanged(int x0, int y0, const Packet& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const int x = x0 + lane % kPacketWidth;
    const int y = y0 + lane / kPacketWidth;
    if (inside(x, y) && picture_.at(x, y).signature != p.signature[lane]) return false;
  }
  return true;
}

std::uint64_t CpuPainter::store_packet(int x0, int y0, const Packet& p) const {
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

void CpuPainter::start_packet(int x0, int y0, Packet& p) const {
  start_(ray_inputs_, x0, y0, p.rays, p.starts);
  p.most_hits = 0;
  p.cut = 0;
}

void CpuPainter::meet_surfaces(int x0, int y0, Packet& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    surfaces_.meet(spec::ray_of(view_, x0 + lane % kPacketWidth, y0 + lane / kPacketWidth),
                   p.hits[lane]);
    p.most_hits = std::max(p.most_hits, p.hits[lane].size());
  }
}

void CpuPainter::cut_packet(int x0, int y0, const CutChoice& choice, Packet& p) const {
  aim_(ray_inputs_, cut_view_, x0, y0, p.cut_rays, p.foot);
  meet_(cutaway_.objects(), choice, p.cut_rays);
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    cut_lane(p.foot[lane] + static_cast<double>(p.cut_rays.t1[lane]),
             p.foot[lane] + static_cast<double>(p.cut_rays.t2[lane]), lane, p);
  }
}

void CpuPainter::cut_by_field(int x0, int y0, Packet& p) const {
  std::array<spec::CutawaySpan<float>, kPacketLanes> spans{};
  // By rows, so that a ray starts its search where its neighbour's ended.
  for (int row = 0; row < kPacketHeight; ++row) {
    field_->meet_row(view_, x0, y0 + row, kPacketWidth, spans.data() + row * kPacketWidth);
  }
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    const spec::CutawaySpan<float>& span = spans[static_cast<std::size_t>(lane)];
    cut_lane(span.t1, span.t2, lane, p);
  }
}

void CpuPainter::cut_lane(double t1_mm, double t2_mm, int lane, Packet& p) const {
  if (!(t2_mm > p.starts.begin[lane])) return;
  const double t2 = t2_mm / step_ - p.starts.base[lane];
  const double t1 = std::max(t1_mm / step_ - p.starts.base[lane], kNowhere);
  p.rays.t2[lane] = static_cast<float>(t2);
  p.rays.t1[lane] = static_cast<float>(t1);
  p.rays.per_transition[lane] = static_cast<float>(std::min(1 / (t2 - t1), -kNowhere));
  // Far more than single precision takes from t2, t1, their difference, and a sum of cells.
  const double overlay = in_.overlay_cells < 1e29F ? static_cast<double>(in_.overlay_cells) : 0;
  p.rays.margin[lane] =
      static_cast<float>(0.02 + 2e-6 * (t2 - t1 + overlay + std::abs(t1) + std::abs(t2)));
  ++p.cut;
}

void CpuPainter::composite(Packet& p, MarchCounts& counts) const {
  const March march = p.cut > 0 ? fading_ : plain_;
  for (std::size_t segment = 0; segment <= p.most_hits; ++segment) {
    if (p.starts.any) {
      if (p.most_hits > 0) set_segment(segment, p);
      march(in_, p.rays, counts);
    }
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      if (segment < p.hits[lane].size()) blend(p.hits[lane][segment], lane, p);
    }
  }
}

void CpuPainter::project(Packet& p, MarchCounts& counts) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    for (const auto& hit : p.hits[lane]) blend(hit, lane, p);
  }
  if (!p.starts.any) return;
  project_(in_, p.rays, counts);
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    const double hu = p.rays.value[lane];
    const double grey =
        std::clamp((hu - scene_.grey.level_hu) / scene_.grey.width_hu + 0.5, 0.0, 1.0);
    blend({p.starts.end[lane], spec::Vec3<double>::Constant(grey), 1.0}, lane, p);
  }
}

// The stretch between the surfaces segment - 1 and segment of every lane.
void CpuPainter::set_segment(std::size_t segment, Packet& p) const {
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

void CpuPainter::blend(const spec::Hit<double>& hit, int lane, Packet& p) const {
  RayPacket& rays = p.rays;
  if (rays.alpha[lane] >= in_.opaque_at) return;
  const float weight = (1 - rays.alpha[lane]) * static_cast<float>(hit.alpha);
  rays.alpha[lane] += weight;
  if (hit.picture) {
    p.seen[lane].weight = weight;
    p.seen[lane].column = static_cast<float>(hit.pixel.x());
    p.seen[lane].row = static_cast<float>(hit.pixel.y());
    return;
  }
  for (int c = 0; c < 3; ++c) rays.rgb[c][lane] += weight * static_cast<float>(hit.rgb[c]);
}

void CpuPainter::store(int x, int y, int lane, const Packet& p) const {
  PixelRecord& record = picture_.at(x, y);
  record = p.seen[lane];
  record.signature = p.signature[lane];
  const float left = 1 - p.rays.alpha[lane];
  for (int c = 0; c < 3; ++c) {
    record.base[c] = p.rays.rgb[c][lane] + left * static_cast<float>(scene_.background_rgb[c]);
  }
}

}  // namespace nav::render
