// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_painter.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

namespace nav::render {
namespace {

constexpr int kBlock = CpuImage::kBlock;  // Pixels; a multiple of the packet's sides.
constexpr int kTile = 32;                 // Pixels; a multiple of a block's side.
constexpr auto kNowhere = static_cast<float>(kCutNowhere);

static_assert(VisibleSpans::kSide == kBlock);
static_assert(LatticeSquares::kTile == kTile);

static_assert(kMarchFadeSteps == spec::kFadeSteps &&
              kMarchFadeVaries == static_cast<float>(spec::kFadeVaries));
static_assert(kMarchMostShades == spec::kMostShades);
static_assert(spec::kMaxBowShare == 0.5, "kMarchMaxBowShare of cpu_kernel_classify.hpp");
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

/// Signature of everything that a ray meets besides the volume. The grey of an ultrasound image
/// does not count, because it is added later. Never 0, which no ray has.
std::uint64_t signature_of(const std::vector<spec::Hit<double>>& hits, float t1, float t2,
                           float overlay) {
  std::uint64_t hash = 1;
  if (t2 > static_cast<float>(kCutNowhere)) {
    add_bits(hash, t1);
    add_bits(hash, t2);
    add_bits(hash, overlay);
  }
  for (const spec::Hit<double>& hit : hits) {
    add_bits(hash, hit.t);
    add_bits(hash, hit.alpha);
    add_bits(hash, hit.image);
    const double values[3] = {hit.image ? hit.pixel.x() : hit.rgb.x(),
                              hit.image ? hit.pixel.y() : hit.rgb.y(), hit.image ? 0 : hit.rgb.z()};
    for (const double value : values) add_bits(hash, value);
  }
  return hash == 0 ? 1 : hash;
}

}  // namespace

struct CpuPainter::Packet : CpuPacket {
  std::uint64_t signature[kPacketLanes];
  PixelRecord seen[kPacketLanes];  ///< The ultrasound image: weight, column, row.
};

/// Working data of a tile.
struct CpuPainter::Tile {
  explicit Tile(const CutObjects& objects) : all(objects), tile(objects), block(objects) {}

  CutSelection all;
  CutSelection tile;
  CutSelection block;
  bool cut = false;  ///< The cutaway may reach a ray of the tile.
  Packet packet{};
  MarchCounts counts{};
  std::uint64_t rays = 0;
  std::uint64_t cut_rays = 0;

  // Used only with sparse rays.
  SurfaceReach reach{};  ///< Surfaces that the blocks until now may meet.
  int waiting = 0;       ///< Number of lanes of the packet that have a pixel.
  std::optional<LatticeSquares> squares;
  std::uint64_t means = 0;
};

CpuPainter::CpuPainter(const Scene& scene, const MarchInputs& in, const MarchKey& key,
                       const MarchSet& marches, const CutPlan& cutaway, const CutawayField* field,
                       CpuImage& image, bool keep, const VisibleSpans* spans,
                       const std::optional<SparseRays>& sparse)
    : scene_(scene),
      in_(in),
      cutaway_(cutaway),
      image_(image),
      keep_(keep),
      spans_(spans),
      sparse_(sparse),
      plain_(marches.composite({key.classify, key.shade, false, key.cells})),
      fading_(key.fade ? marches.composite(key) : plain_),
      project_(marches.project(project_of(scene.projection))),
      rays_of_(scene, marches, cutaway, field,
               key.classify == MarchClassify::kPreIntegrated &&
                       scene.projection == Projection::kComposite
                   ? 0.0
                   : 0.5,
               in.overlay_cells),
      tiles_across_((scene.width + kTile - 1) / kTile),
      tiles_down_((scene.height + kTile - 1) / kTile) {
  if (sparse_) lattice_.emplace(scene.width, scene.height, sparse_->stride);
}

void CpuPainter::paint_tile(int index, int pass) {
  const int x0 = index % tiles_across_ * kTile;
  const int y0 = index / tiles_across_ * kTile;
  Tile tile(cutaway_.objects());
  tile.cut = rays_of_.cuts() && rays_of_.cull(x0, y0, kTile, tile.all.choice(), tile.tile.choice());
  for (int y = y0; y < std::min(y0 + kTile, scene_.height); y += kBlock) {
    for (int x = x0; x < std::min(x0 + kTile, scene_.width); x += kBlock) {
      paint_block(x, y, pass, tile);
    }
  }
  paint_added(tile);
  rays_ += tile.rays;
  samples_ += tile.counts.samples;
  passed_ += tile.counts.passed;
  gradients_ += tile.counts.gradients;
  window_gradients_ += tile.counts.window_gradients;
  faded_ += tile.counts.faded;
  cutaway_rays_ += tile.cut_rays;
  means_ += tile.means;
}

void CpuPainter::paint_block(int x0, int y0, int pass, Tile& tile) {
  const SurfaceReach reach = rays_of_.reach(x0, y0, kBlock);
  const VisibleSpan span = spans_ != nullptr ? spans_->at(x0, y0) : VisibleSpan{};
  if (span.empty() && !reach.any()) {
    if (pass == 0) tile.rays += leave_empty(x0, y0);
    return;
  }
  if (pass == 0) image_.set_blank(x0, y0, false);
  if (!lattice_) {
    cast_all(x0, y0, reach, span, tile);
    return;
  }
  tile.reach = tile.reach.with(reach);
  if (pass == 0) {
    add_lattice(x0, y0, span, tile);
  } else {
    halve_squares(x0, y0, pass, reach, span, tile);
  }
}

void CpuPainter::cast_all(int x0, int y0, const SurfaceReach& reach, const VisibleSpan& span,
                          Tile& tile) {
  const bool cut =
      tile.cut && rays_of_.cull(x0, y0, kBlock, tile.tile.choice(), tile.block.choice());
  for (int y = y0; y < std::min(y0 + kBlock, scene_.height); y += kPacketHeight) {
    for (int x = x0; x < std::min(x0 + kBlock, scene_.width); x += kPacketWidth) {
      rays_of_.start(x, y, reach, cut ? &tile.block.choice() : nullptr, span, tile.packet);
      paint_packet(tile);
    }
  }
}

/// Paints a packet that was started.
void CpuPainter::paint_packet(Tile& tile) {
  Packet& p = tile.packet;
  std::fill_n(p.seen, kPacketLanes, PixelRecord{});
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    p.signature[lane] =
        signature_of(p.hits[lane], p.rays.t1[lane], p.rays.t2[lane], in_.overlay_cells);
  }
  if (keep_ && unchanged(p)) return;
  tile.cut_rays += static_cast<std::uint64_t>(p.cut);
  if (scene_.projection == Projection::kComposite) {
    composite(p, tile.counts);
  } else {
    project(p, tile.counts);
  }
  tile.rays += store_packet(p);
}

/// Decides which pixels in the middle of squares and of their edges get a ray and which get a mean.
void CpuPainter::halve_squares(int x0, int y0, int pass, const SurfaceReach& reach,
                               const VisibleSpan& span, Tile& tile) {
  if (!tile.squares) {
    tile.squares.emplace(image_, *lattice_, sparse_->error);
    tile.squares->find(x0 / kTile * kTile, y0 / kTile * kTile, lattice_->side(pass));
  }
  const int side = lattice_->side(pass);
  const int step = side / 2;
  for (int y = y0; y <= std::min(y0 + kBlock - 1, lattice_->last_y); y += step) {
    for (int x = x0; x <= std::min(x0 + kBlock - 1, lattice_->last_x); x += step) {
      if (x % side == 0 && y % side == 0) continue;
      if (reach.shapes || !tile.squares->even_around(x, y) ||
          (reach.plane && rays_of_.meets_border(x, y))) {
        add_pixel(x, y, span, tile);
      } else {
        tile.squares->fill(x, y);
        ++tile.means;
      }
    }
  }
}

void CpuPainter::add_lattice(int x0, int y0, const VisibleSpan& span, Tile& tile) {
  const bool whole = !lattice_->beyond(x0 + kBlock - 1, y0 + kBlock - 1);
  const int step = whole ? lattice_->stride : 1;
  for (int y = y0; y < std::min(y0 + kBlock, scene_.height); y += step) {
    for (int x = x0; x < std::min(x0 + kBlock, scene_.width); x += step) {
      const bool on = x % lattice_->stride == 0 && y % lattice_->stride == 0;
      if (on || lattice_->beyond(x, y)) add_pixel(x, y, span, tile);
    }
  }
}

void CpuPainter::add_pixel(int x, int y, const VisibleSpan& span, Tile& tile) {
  Packet& p = tile.packet;
  p.pixels.x[tile.waiting] = x;
  p.pixels.y[tile.waiting] = y;
  p.spans[tile.waiting] = span;
  if (++tile.waiting == kPacketLanes) paint_added(tile);
}

void CpuPainter::paint_added(Tile& tile) {
  if (tile.waiting == 0) return;
  for (int lane = tile.waiting; lane < kPacketLanes; ++lane) {
    tile.packet.pixels.x[lane] = scene_.width;
    tile.packet.pixels.y[lane] = scene_.height;
    tile.packet.spans[lane] = {};
  }
  tile.waiting = 0;
  rays_of_.start(tile.reach, tile.cut ? &tile.tile.choice() : nullptr, tile.packet);
  paint_packet(tile);
}

/// Paints a block whose rays meet nothing. Returns the number of rays that were not known to meet
/// nothing.
std::uint64_t CpuPainter::leave_empty(int x0, int y0) const {
  std::uint64_t rays = 0;
  if (image_.blank(x0, y0)) return rays;
  image_.set_blank(x0, y0, true);
  PixelRecord record{};
  record.signature = signature_of({}, kNowhere, kNowhere, 0);
  for (int c = 0; c < 3; ++c) record.base[c] = static_cast<float>(scene_.background_rgb[c]);
  for (int y = y0; y < std::min(y0 + kBlock, scene_.height); ++y) {
    for (int x = x0; x < std::min(x0 + kBlock, scene_.width); ++x) {
      PixelRecord& last = image_.at(x, y);
      if (keep_ && last.signature == record.signature) continue;
      last = record;
      ++rays;
    }
  }
  return rays;
}

RenderStatistics CpuPainter::statistics() const {
  RenderStatistics statistics;
  statistics.rays = rays_;
  statistics.volume_samples = samples_;
  statistics.passed_samples = passed_;
  statistics.gradient_samples = gradients_;
  statistics.window_gradients = window_gradients_;
  statistics.cutaway_rays = cutaway_rays_;
  statistics.faded_cells = faded_;
  statistics.pixels_without_ray = means_;
  return statistics;
}

bool CpuPainter::unchanged(const Packet& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const int x = p.pixels.x[lane];
    const int y = p.pixels.y[lane];
    if (inside(x, y) && image_.at(x, y).signature != p.signature[lane]) return false;
  }
  return true;
}

std::uint64_t CpuPainter::store_packet(const Packet& p) const {
  std::uint64_t rays = 0;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!inside(p.pixels.x[lane], p.pixels.y[lane])) continue;
    store(lane, p);
    ++rays;
  }
  return rays;
}

void CpuPainter::composite(Packet& p, MarchCounts& counts) const {
  const March march = p.cut > 0 ? fading_ : plain_;
  for (std::size_t segment = 0; segment <= p.most_hits; ++segment) {
    if (p.starts.any) {
      if (p.most_hits > 0) rays_of_.set_segment(segment, p);
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

void CpuPainter::blend(const spec::Hit<double>& hit, int lane, Packet& p) const {
  RayPacket& rays = p.rays;
  if (rays.alpha[lane] >= in_.opaque_at) return;
  const float weight = (1 - rays.alpha[lane]) * static_cast<float>(hit.alpha);
  rays.alpha[lane] += weight;
  if (hit.image) {
    p.seen[lane].weight = weight;
    p.seen[lane].column = static_cast<float>(hit.pixel.x());
    p.seen[lane].row = static_cast<float>(hit.pixel.y());
    return;
  }
  for (int c = 0; c < 3; ++c) rays.rgb[c][lane] += weight * static_cast<float>(hit.rgb[c]);
}

void CpuPainter::store(int lane, const Packet& p) const {
  PixelRecord& record = image_.at(p.pixels.x[lane], p.pixels.y[lane]);
  record = p.seen[lane];
  record.signature = p.signature[lane];
  const float alpha = p.rays.alpha[lane];
  const bool closed = alpha >= in_.opaque_at;
  const float share = closed ? 1 / alpha : 1.0F;
  const float left = closed ? 0.0F : 1 - alpha;
  record.weight *= share;
  for (int c = 0; c < 3; ++c) {
    record.base[c] =
        share * p.rays.rgb[c][lane] + left * static_cast<float>(scene_.background_rgb[c]);
  }
}

}  // namespace nav::render
