// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <thread>

#include "render/cpu_cache.hpp"
#include "render/cpu_cutaway_plan.hpp"
#include "render/cpu_inputs.hpp"
#include "render/cpu_painter.hpp"
#include "render/engine.hpp"
#include "render/parallel.hpp"
#include "render/ray_spec.hpp"

namespace nav::render {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class CpuEngine final : public Engine {
 public:
  explicit CpuEngine(const CpuOptions& options)
      : options_(options), vector_(options.allow_vector ? vector_marches() : MarchSet{}) {}

  [[nodiscard]] std::string name() const override { return "cpu"; }
  [[nodiscard]] std::string device() const override {
    const unsigned threads = options_.threads > 0 ? static_cast<unsigned>(options_.threads)
                                                  : std::thread::hardware_concurrency();
    return std::string(vector_.composite != nullptr ? "AVX2, " : "portable, ") +
           std::to_string(threads) + (threads == 1 ? " thread" : " threads");
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
    const CutPlan cutaway(spec::make_cutaway(scene, true));
    cache_.update(scene, !cutaway.empty(), options_.threads);
    const double prepare_s = seconds_since(start);
    const MarchKey key = march_key(scene, cache_, !cutaway.empty());
    const MarchInputs in = march_inputs(scene, cache_, key);
    CpuPainter painter(scene, in, key, vector_.composite != nullptr ? vector_ : portable_marches(),
                       cutaway);
    for_each_index(painter.tiles(), options_.threads, [&](int tile) { painter.paint_tile(tile); });
    RenderedImage image = painter.finish();
    if (scene.quality.skip_empty_bricks) {
      image.statistics.bricks = cache_.bricks()->low.size();
      if (cache_.distances()) image.statistics.bricks_occupied = cache_.distances()->occupied;
    }
    image.statistics.prepare_s = prepare_s;
    image.statistics.cast_s = seconds_since(start) - prepare_s;
    return image;
  }

 private:
  CpuOptions options_;
  MarchSet vector_;
  CpuCache cache_;
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(const CpuOptions& options) {
  return std::make_unique<CpuEngine>(options);
}

}  // namespace nav::render
