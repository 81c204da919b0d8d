// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "render/brick_grid.hpp"
#include "render/cpu_march.hpp"
#include "render/cpu_transfer.hpp"
#include "render/cpu_volume.hpp"
#include "render/engine.hpp"
#include "render/parallel.hpp"
#include "render/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPacketWidth = 4;
constexpr int kPacketHeight = kPacketLanes / kPacketWidth;
constexpr int kTile = 32;  // Pixels; a multiple of the packet's sides.

constexpr std::size_t kTail = 3;  // A brick's byte is fetched as the first of four.
static_assert(kBrickVoxels == 8, "The march finds a sample's brick by a shift of 3 bits.");

/// How much colour all samples of a ray together may miss by staying unshaded because each of
/// them weighs too little.
constexpr double kShadingBudget = 1.0 / 512;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What is kept from one picture to the next.
struct Cache {
  std::shared_ptr<const Volume> ct;  ///< Held, so that its address stays its own.
  std::optional<CpuVolume> volume;
  std::optional<BrickGrid> bricks;  ///< This and the distances: made when first needed.
  std::optional<TransferFunction> transfer;
  std::optional<TransferTable> table;
  std::vector<TableEntry> entries;
  std::optional<BrickDistances> distances;  ///< And kTail bytes that nobody counts.

  void update(const Scene& scene, int threads) {
    if (ct != scene.ct) {
      volume.emplace(*scene.ct, threads);
      ct = scene.ct;
      bricks.reset();
      distances.reset();
    }
    if (!transfer || !same_classification(*transfer, scene.transfer)) {
      transfer = scene.transfer;
      table.emplace(scene.transfer);
      entries = march_entries(*table);
      distances.reset();
    }
    if (!scene.quality.skip_empty_bricks || distances) return;
    if (!bricks) bricks = make_brick_grid(*ct, threads);
    distances = brick_distances(*bricks, *table);
    distances->distance.resize(distances->distance.size() + kTail);
  }
};

MarchInputs make_inputs(const Scene& scene, const Cache& cache) {
  const VoxelGrid& grid = scene.ct->grid();
  const double step = spec::step_mm(scene.quality, grid);
  MarchInputs in{};
  in.voxels = cache.volume->origin();
  in.row_stride = cache.volume->row_stride();
  in.slice_stride = cache.volume->slice_stride();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    in.last[axis] = static_cast<float>(grid.size[a] - 1);
    in.half_per_spacing[axis] = static_cast<float>(0.5 / grid.spacing_mm[axis]);
    in.mm_per_index_step[axis] = static_cast<float>(grid.spacing_mm[axis] / step);
  }
  if (scene.quality.skip_empty_bricks) {
    in.brick_distance = cache.distances->distance.data();
    std::copy_n(cache.bricks->count.data(), 3, in.bricks);
  }
  in.table = cache.entries.data();
  in.table_low_hu = static_cast<float>(cache.table->first_hu());
  in.table_high_hu = static_cast<float>(cache.table->last_hu());
  in.invisible_up_to_hu = static_cast<float>(cache.table->invisible_up_to_hu());
  in.step_mm = static_cast<float>(step);
  in.opaque_at = scene.quality.opaque_at < 1 ? static_cast<float>(scene.quality.opaque_at)
                                             : std::numeric_limits<float>::infinity();
  in.shading = scene.shading.enabled;
  in.per_full_gradient = static_cast<float>(1 / scene.shading.full_gradient_per_mm);
  in.ambient = static_cast<float>(scene.shading.ambient);
  in.diffuse = static_cast<float>(scene.shading.diffuse);
  in.specular = static_cast<float>(scene.shading.specular);
  in.shininess = static_cast<float>(scene.shading.shininess);
  // A ray crosses at most diagonal / step + 2 cells.
  const double cells = grid.extent_mm().norm() / step + 2;
  in.min_shaded_weight = static_cast<float>(kShadingBudget / cells);
  return in;
}

/// Draws tiles of one picture. Thread-safe: each tile keeps its state on its own stack.
class Painter {
 public:
  Painter(const Scene& scene, const MarchInputs& in, March march)
      : scene_(scene),
        in_(in),
        march_(march),
        surfaces_(scene),
        view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
        step_(spec::step_mm(scene.quality, scene.ct->grid())),
        pixels_(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height)) {}

  [[nodiscard]] int tiles_across() const { return (scene_.width + kTile - 1) / kTile; }
  [[nodiscard]] int tiles_down() const { return (scene_.height + kTile - 1) / kTile; }

  void paint_tile(int tile) {
    const int x0 = tile % tiles_across() * kTile;
    const int y0 = tile / tiles_across() * kTile;
    MarchCounts counts{};
    Packet packet{};
    for (int y = y0; y < std::min(y0 + kTile, scene_.height); y += kPacketHeight) {
      for (int x = x0; x < std::min(x0 + kTile, scene_.width); x += kPacketWidth) {
        paint_packet(x, y, packet, counts);
      }
    }
    samples_ += counts.samples;
    gradients_ += counts.gradients;
  }

  /// The picture; call once, when every tile is painted.
  RenderedImage finish() {
    RenderedImage image{{scene_.width, scene_.height, std::move(pixels_)}, {}};
    image.statistics.rays = image.pixels.pixels().size();
    image.statistics.volume_samples = samples_;
    image.statistics.gradient_samples = gradients_;
    return image;
  }

 private:
  struct Packet {
    RayPacket rays;
    double base[kPacketLanes];  ///< Cell of the lattice that a lane counts from.
    spec::Interval<double> box[kPacketLanes];
    std::vector<spec::Hit<double>> hits[kPacketLanes];
  };

  void paint_packet(int x0, int y0, Packet& p, MarchCounts& counts) {
    bool in_box = false;
    std::size_t most_hits = 0;
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      // Lanes beyond the picture's edge stay empty.
      const int x = x0 + lane % kPacketWidth;
      const int y = y0 + lane / kPacketWidth;
      start_lane(x, y, lane, p);
      in_box = in_box || p.box[lane].end > p.box[lane].begin;
      most_hits = std::max(most_hits, p.hits[lane].size());
    }
    for (std::size_t segment = 0; segment <= most_hits; ++segment) {
      if (in_box) {
        set_segment(segment, p);
        march_(in_, p.rays, counts);
      }
      for (int lane = 0; lane < kPacketLanes; ++lane) {
        if (segment < p.hits[lane].size()) blend(p.hits[lane][segment], lane, p.rays);
      }
    }
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      const int x = x0 + lane % kPacketWidth;
      const int y = y0 + lane / kPacketWidth;
      if (x < scene_.width && y < scene_.height) store(x, y, lane, p.rays);
    }
  }

  void start_lane(int x, int y, int lane, Packet& p) {
    p.hits[lane].clear();
    p.box[lane] = {0, 0};
    p.base[lane] = 0;
    p.rays.alpha[lane] = 0;
    for (int axis = 0; axis < 3; ++axis) {
      p.rays.rgb[axis][lane] = 0;
      p.rays.origin[axis][lane] = 0;
      p.rays.step[axis][lane] = 0;
    }
    if (x >= scene_.width || y >= scene_.height) return;
    const auto ray = spec::ray_of(view_, x, y);
    if (!surfaces_.empty()) surfaces_.meet(ray, p.hits[lane]);
    const auto index = spec::index_ray(ray, scene_.ct->grid());
    const auto in = spec::clip_to_box(index, scene_.ct->grid().size);
    if (!(in.end > in.begin)) return;
    p.box[lane] = in;
    p.base[lane] = std::floor(in.begin / step_);
    const double centre = (p.base[lane] + 0.5) * step_;
    for (int axis = 0; axis < 3; ++axis) {
      p.rays.origin[axis][lane] =
          static_cast<float>(index.origin[axis] + centre * index.direction[axis]);
      p.rays.step[axis][lane] = static_cast<float>(step_ * index.direction[axis]);
    }
  }

  /// The stretch between the surfaces segment - 1 and segment of every lane.
  void set_segment(std::size_t segment, Packet& p) const {
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      const auto& hits = p.hits[lane];
      double begin = p.box[lane].begin;
      double end = p.box[lane].end;
      if (segment > 0 && segment <= hits.size()) begin = std::max(begin, hits[segment - 1].t);
      if (segment < hits.size()) end = std::min(end, hits[segment].t);
      const bool past = segment > hits.size() ||
                        (segment == hits.size() && segment > 0 && hits.back().alpha >= 1);
      if (past || !(end > begin)) {
        p.rays.begin[lane] = p.rays.end[lane] = 0;
        continue;
      }
      p.rays.begin[lane] = static_cast<float>(begin / step_ - p.base[lane]);
      p.rays.end[lane] = static_cast<float>(end / step_ - p.base[lane]);
    }
  }

  void blend(const spec::Hit<double>& hit, int lane, RayPacket& rays) const {
    if (rays.alpha[lane] >= in_.opaque_at) return;
    const float weight = (1 - rays.alpha[lane]) * static_cast<float>(hit.alpha);
    for (int c = 0; c < 3; ++c) rays.rgb[c][lane] += weight * static_cast<float>(hit.rgb[c]);
    rays.alpha[lane] += weight;
  }

  void store(int x, int y, int lane, const RayPacket& rays) {
    const float left = 1 - rays.alpha[lane];
    const auto channel = [&](int c) {
      return rays.rgb[c][lane] + left * static_cast<float>(scene_.background_rgb[c]);
    };
    pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene_.width) +
            static_cast<std::size_t>(x)] = {channel(0), channel(1), channel(2), 1.0F};
  }

  const Scene& scene_;
  const MarchInputs& in_;
  March march_;
  Surfaces surfaces_;
  spec::View<double> view_;
  double step_;
  std::vector<RgbaF> pixels_;
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> gradients_{0};
};

class CpuEngine final : public Engine {
 public:
  explicit CpuEngine(const CpuOptions& options)
      : options_(options), vector_(options.allow_vector ? vector_march() : nullptr) {}

  [[nodiscard]] std::string name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override {
    const unsigned threads = options_.threads > 0 ? static_cast<unsigned>(options_.threads)
                                                  : std::thread::hardware_concurrency();
    return std::string(vector_ != nullptr ? "AVX2, " : "portable, ") + std::to_string(threads) +
           (threads == 1 ? " thread" : " threads");
  }

  Result<RenderedImage> render(const Scene& scene) override {
    if (const auto ok = validate(scene); !ok) return ok.error();
    if (!CpuVolume::fits(scene.ct->grid())) {
      return Error{ErrorCode::kUnsupportedData,
                   scene.ct->name() +
                       ": expected fewer than 2^31 voxels with their border, found " +
                       std::to_string(scene.ct->grid().voxel_count()) + " without it"};
    }
    const auto start = Clock::now();
    cache_.update(scene, options_.threads);
    const double prepare_s = seconds_since(start);
    const MarchInputs in = make_inputs(scene, cache_);
    Painter painter(scene, in, vector_ != nullptr ? vector_ : march_portable);
    for_each_index(painter.tiles_across() * painter.tiles_down(), options_.threads,
                   [&](int tile) { painter.paint_tile(tile); });
    RenderedImage image = painter.finish();
    if (scene.quality.skip_empty_bricks) {
      image.statistics.bricks = cache_.bricks->low.size();
      image.statistics.bricks_occupied = cache_.distances->occupied;
    }
    image.statistics.prepare_s = prepare_s;
    image.statistics.cast_s = seconds_since(start) - prepare_s;
    return image;
  }

 private:
  CpuOptions options_;
  March vector_;
  Cache cache_;
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(const CpuOptions& options) {
  return std::make_unique<CpuEngine>(options);
}

}  // namespace nav::render
