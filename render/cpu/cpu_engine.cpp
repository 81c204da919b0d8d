// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include "nav/stopwatch.hpp"
#include "render/cpu/cpu_cache.hpp"
#include "render/cpu/cpu_cutaway_plan.hpp"
#include "render/cpu/cpu_image.hpp"
#include "render/cpu/cpu_inputs.hpp"
#include "render/cpu/cpu_marches.hpp"
#include "render/cpu/cpu_painter.hpp"
#include "render/cpu/cpu_predicate_painter.hpp"
#include "render/cutaway_mesh.hpp"
#include "render/engine.hpp"
#include "render/interruptible.hpp"
#include "render/quality/sparse_rays.hpp"
#include "render/scene_compare.hpp"
#include "render/skipping/coarse_volumes.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

using Clock = std::chrono::steady_clock;

Result<void> check_size(const StoredVolume& volume) {
  if (CpuVolume::fits(volume.grid())) return {};
  return Error{ErrorCode::kUnsupportedData,
               volume.name() + ": expected fewer than 2^31 voxels including a border, found " +
                   std::to_string(volume.grid().voxel_count()) + " without it"};
}

/// The objects of a scene's cutaway, or none if a field replaces them.
spec::CutawayObjects<double> cut_objects(const Scene& scene, bool by_field) {
  return by_field ? spec::CutawayObjects<double>{} : spec::make_cutaway(scene, true);
}

class CpuEngine final : public Engine {
 public:
  explicit CpuEngine(const CpuOptions& options)
      : options_(options), marches_(cpu_marches(options.lanes)) {}

  [[nodiscard]] std::string name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override {
    const unsigned threads = options_.threads > 0 ? static_cast<unsigned>(options_.threads)
                                                  : std::thread::hardware_concurrency();
    return std::string(marches_.name) + ", " + std::to_string(threads) +
           (threads == 1 ? " thread" : " threads");
  }

  Result<RenderedImage> render_image(const Scene& scene, const Interrupt& interrupt) override {
    if (const auto ok = validate(scene); !ok) return ok.error();
    if (const auto ok = check_size(*scene.ct); !ok) return ok.error();
    if (scene.ultrasound) {
      if (const auto ok = check_size(*scene.ultrasound->volume); !ok) return ok.error();
    }
    const SceneChange change = change_since_last(scene);
    if (change == SceneChange::kNothing) return RenderedImage{pixels_, {}};
    const auto start = Clock::now();
    RenderedImage image;
    if (change >= SceneChange::kGeometry) {
      last_.reset();  // Set again after every ray of the new scene is cast.
      std::optional<RenderStatistics> statistics;
      if (const auto lacking = set_lacking(scene)) {
        statistics = cast_provisional(scene, *lacking, interrupt);
      } else {
        release_coarse();
        statistics = cast(scene, change == SceneChange::kGeometry, predicates_, interrupt);
      }
      if (!statistics) {
        // Every ray that is there belongs to its own signature: the next image may keep it. With
        // sparse rays it depends, by rounding, on the rays that were cast together with it.
        whole_ = false;
        if (change == SceneChange::kGeometry && !sparse_rays(scene)) last_ = scene;
        return interrupted_error(name());
      }
      whole_ = true;
      image.statistics = *statistics;
      image_.collect(scene.plane.has_value(), options_.threads);
    }
    if (!image.statistics.provisional) last_ = scene;
    const auto plane =
        scene.plane ? spec::make_plane<float>(*scene.plane, scene.ct->grid()) : std::nullopt;
    pixels_ = {};  // Releases its buffer.
    image.pixels = image_.finish(plane ? &*plane : nullptr, options_.threads);
    pixels_ = image.pixels;
    image.statistics.cast_s = seconds_since(start) - image.statistics.prepare_s;
    return image;
  }

 private:
  /// The change from the records that image_ has. Rays are missing after an interrupted image.
  [[nodiscard]] SceneChange change_since_last(const Scene& scene) const {
    if (!last_) return SceneChange::kView;
    const SceneChange change = change_between(*last_, scene);
    return whole_ ? change : std::max(change, SceneChange::kGeometry);
  }

  /// The predicate set of a scene whose image has to be provisional; otherwise no value.
  [[nodiscard]] std::optional<PredicateSet> set_lacking(const Scene& scene) const {
    if (!scene.quality.provisional) return std::nullopt;
    if (has_two_volumes(scene)) return set_lacking_of(ultrasound_scene(scene));
    return drawn_by_predicates(scene) ? set_lacking_of(scene) : std::nullopt;
  }

  [[nodiscard]] std::optional<PredicateSet> set_lacking_of(const Scene& by_predicates) const {
    // A new volume has to be copied in any case.
    if (!predicates_.has(by_predicates.ct.get())) return std::nullopt;
    auto set = *PredicateSet::create(*by_predicates.predicates, by_predicates.ct,
                                     position_of(by_predicates));
    if (predicates_.missing_bytes(set) <= kBytesAImage) return std::nullopt;
    return set;
  }

  /// Draws a provisional image. Before that, it prepares a part of the data that the set lacks,
  /// except for the first image, which has to appear soon. None: interrupted.
  std::optional<RenderStatistics> cast_provisional(const Scene& scene, const PredicateSet& set,
                                                   const Interrupt& interrupt) {
    const auto start = Clock::now();
    RenderStatistics statistics;
    if (provisional_) predicates_.prepare_some(set, kBytesAImage, options_.threads);
    // Does not draw the same provisional image again.
    if (!provisional_ || change_between(*provisional_, scene) != SceneChange::kNothing) {
      provisional_.reset();
      if (!coarse_) coarse_.emplace();
      const Scene coarse = coarse_of(scene, set);
      const double halving_s = seconds_since(start);
      const auto cast_it = cast(coarse, false, coarse_->predicates, interrupt);
      if (!cast_it) return std::nullopt;
      statistics = *cast_it;
      statistics.prepare_s += halving_s;
      provisional_ = scene;
    } else {
      statistics.prepare_s = seconds_since(start);
    }
    statistics.provisional = true;
    return statistics;
  }

  /// The coarse version of a scene. A CT beside the ultrasound stays unchanged.
  Scene coarse_of(const Scene& scene, const PredicateSet& set) {
    if (!has_two_volumes(scene)) return coarse_->volumes.of(scene, set);
    const Scene coarse = coarse_->volumes.of(ultrasound_scene(scene), set);
    Scene out = scene;
    out.ultrasound->volume = coarse.ct;
    out.ultrasound->predicates = *coarse.predicates;
    return out;
  }

  void release_coarse() {
    coarse_.reset();
    provisional_.reset();
  }

  /// Casts the rays. \p keep: cast only the rays that a change affects. None: interrupted.
  std::optional<RenderStatistics> cast(const Scene& scene, bool keep, CpuPredicates& predicates,
                                       const Interrupt& interrupt) {
    const auto start = Clock::now();
    const bool large_meshes = CutawayField::needed(scene);
    if (large_meshes) {
      field_ = CutawayField(scene, field_ ? &*field_ : nullptr);
    } else {
      field_.reset();
    }
    const CutPlan cutaway(cut_objects(scene, large_meshes));
    const bool fades = large_meshes || !cutaway.empty();
    if (drawn_by_predicates(scene)) {
      return cast_predicates(scene, cutaway, predicates, start, interrupt);
    }
    cache_.update(scene, fades, options_.threads);
    if (has_two_volumes(scene)) {
      return cast_both(scene, cutaway, predicates, fades, start, interrupt);
    }
    if (!keep) image_.start(scene.width, scene.height, &scene.background_rgb);
    const double prepare_s = seconds_since(start);
    const MarchKey key = march_key(scene, cache_, fades);
    const MarchInputs in = march_inputs(scene, cache_, key);
    if (!keep) find_spans(scene);
    CpuPainter painter(scene, in, key, marches_.rays, cutaway, field_ ? &*field_ : nullptr, image_,
                       keep, spans_ ? &*spans_ : nullptr, sparse_rays(scene));
    for (int pass = 0; pass < painter.passes(); ++pass) {
      if (!for_each_index(painter.tiles(), options_.threads, interrupt,
                          [&](int tile) { painter.paint_tile(tile, pass); })) {
        return std::nullopt;
      }
    }
    RenderStatistics statistics = painter.statistics();
    if (scene.quality.skip_empty_bricks) {
      statistics.bricks = cache_.bricks()->low.size();
      if (cache_.distances()) statistics.bricks_occupied = cache_.distances()->occupied;
    }
    cache_.count_rays(statistics.rays);
    statistics.prepare_s = prepare_s;
    return statistics;
  }

  /// Finds the visible spans of a single volume whose empty bricks are skipped.
  void find_spans(const Scene& scene) {
    spans_.reset();
    if (!scene.quality.skip_empty_bricks || scene.projection != Projection::kComposite) return;
    if (!VisibleSpans::worth(scene, cache_.shell())) return;
    spans_.emplace(scene, cache_.shell(), options_.threads);
  }

  std::optional<RenderStatistics> cast_predicates(const Scene& scene, const CutPlan& cutaway,
                                                  CpuPredicates& predicates,
                                                  Clock::time_point start,
                                                  const Interrupt& interrupt) {
    predicates.update(scene, options_.threads);
    image_.start(scene.width, scene.height, nullptr);
    const double prepare_s = seconds_since(start);
    CpuPredicatePainter painter(scene, predicates, marches_, cutaway, field_ ? &*field_ : nullptr,
                                image_, {});
    if (!for_each_index(painter.tiles(), options_.threads, interrupt,
                        [&](int tile) { painter.paint_tile(tile); })) {
      return std::nullopt;
    }
    RenderStatistics statistics = painter.statistics();
    statistics.bricks = predicates.bricks();
    statistics.bricks_occupied = predicates.bricks_occupied();
    statistics.prepare_s = prepare_s;
    return statistics;
  }

  /// Casts the CT, for which cache_ is ready, and the ultrasound volume in it.
  std::optional<RenderStatistics> cast_both(const Scene& scene, const CutPlan& ct_cutaway,
                                            CpuPredicates& predicates, bool fades,
                                            Clock::time_point start, const Interrupt& interrupt) {
    const UltrasoundVolume& ultrasound = *scene.ultrasound;
    Scene other = ultrasound_scene(scene);
    predicates.update(other, options_.threads, ultrasound.ct_importance);
    image_.start(scene.width, scene.height, nullptr);
    const CutawayField* field = field_ ? &*field_ : nullptr;
    if (field != nullptr) {
      other_field_ = CutawayField(other, other_field_ ? &*other_field_ : nullptr);
    } else {
      other_field_.reset();
    }
    const CutPlan cutaway(cut_objects(other, field != nullptr));
    const MarchKey key = march_key(scene, cache_, fades);
    const MarchInputs in = march_inputs(scene, cache_, key);
    const CpuCtBeside ct(scene, in, key, marches_.rays, ct_cutaway, field);
    const double error = std::exchange(other.predicates->termination_error, 0.0);
    CpuPredicatePainter painter(other, predicates, marches_, cutaway,
                                other_field_ ? &*other_field_ : nullptr, image_,
                                {&ct, ultrasound.ct_importance, error});
    const double prepare_s = seconds_since(start);
    if (!for_each_index(painter.tiles(), options_.threads, interrupt,
                        [&](int tile) { painter.paint_tile(tile); })) {
      return std::nullopt;
    }
    RenderStatistics statistics = painter.statistics();
    statistics.bricks = predicates.bricks();
    statistics.bricks_occupied = predicates.bricks_occupied();
    cache_.count_rays(statistics.rays);
    if (scene.quality.skip_empty_bricks) {
      statistics.bricks += cache_.bricks()->low.size();
      if (cache_.distances()) statistics.bricks_occupied += cache_.distances()->occupied;
    }
    statistics.prepare_s = prepare_s;
    return statistics;
  }

  /// Data for drawing provisional images.
  struct Coarse {
    CoarseVolumes volumes;
    CpuPredicates predicates;
  };

  CpuOptions options_;
  CpuMarches marches_;
  CpuCache cache_;
  CpuPredicates predicates_;
  std::optional<Coarse> coarse_;
  std::optional<Scene> provisional_;  ///< Scene of the last image, if that was provisional.
  std::optional<CutawayField> field_;
  std::optional<CutawayField> other_field_;  ///< field_ in the coordinates of the ultrasound
                                             ///< volume.
  std::optional<VisibleSpans> spans_;        ///< Spans of the last scene whose view changed.
  CpuImage image_;
  std::optional<Scene> last_;  ///< Scene that image_ shows, or, unless whole_, parts of it.
  bool whole_ = false;         ///< False: the last image was interrupted.
  Image2d<RgbaF> pixels_;      ///< The last returned image.
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(const CpuOptions& options) {
  return std::make_unique<CpuEngine>(options);
}

}  // namespace nav::render
