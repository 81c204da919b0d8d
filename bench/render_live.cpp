// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_live.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

#include "bench/moving_camera.hpp"
#include "bench/until_whole.hpp"
#include "nav/time.hpp"
#include "render/engine.hpp"
#include "render/skipping/visible_cells.hpp"

namespace nav::bench {
namespace {

bool same_bytes(const render::RenderedImage& a, const render::RenderedImage& b) {
  const auto x = a.pixels.pixels();
  const auto y = b.pixels.pixels();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
}

/// The scene with \p factor times fewer pixels along each axis.
render::Scene smaller(render::Scene scene, int factor) {
  scene.width /= factor;
  scene.height /= factor;
  return scene;
}

/// Medians of scenes drawn in turn; the first image of each fills the caches.
Result<std::vector<Taken>> time_scenes(std::vector<MovingCamera>& cameras, const Repeats& repeats) {
  std::vector<Task> tasks;
  for (MovingCamera& camera : cameras) {
    if (auto warm = camera.draw(); !warm) return warm.error();
    tasks.push_back([&camera] { return camera.draw(); });
  }
  return time_in_turn(tasks, repeats);
}

}  // namespace

Result<CutawayCost> measure_cutaway(const render::Scene& scene, const Repeats& repeats) {
  NAV_CHECK(scene.plane && scene.cutaway);
  render::Scene with_plane = scene;
  with_plane.cutaway.reset();
  render::Scene ct = with_plane;
  ct.plane.reset();
  constexpr double kCoarser = 1.5;
  render::Scene coarse_ct = ct;
  coarse_ct.quality.step_voxels *= kCoarser;
  std::vector<MovingCamera> cameras;
  for (const render::Scene& one : {ct, coarse_ct, with_plane, scene}) cameras.emplace_back(one);
  const auto taken = time_scenes(cameras, repeats);
  if (!taken) return taken.error();
  CutawayCost cost;
  cost.ct_ms = 1e3 * (*taken)[0].cpu_s;
  cost.coarse_ct_ms = 1e3 * (*taken)[1].cpu_s;
  cost.plane_ms = 1e3 * (*taken)[2].cpu_s;
  cost.cutaway_ms = 1e3 * (*taken)[3].cpu_s;
  cost.ct_samples = cameras[0].statistics().volume_samples;
  cost.coarse_ct_samples = cameras[1].statistics().volume_samples;
  cost.plane_samples = cameras[2].statistics().volume_samples;
  cost.cutaway_samples = cameras[3].statistics().volume_samples;
  return cost;
}

Result<ImageUpdate> measure_image_update(const render::Scene& scene, int updates) {
  NAV_CHECK(scene.plane.has_value());
  const auto engine = render::make_cpu_engine();
  if (auto first = engine->render(scene); !first) return first.error();
  render::Scene next = scene;
  const Image2d<std::uint8_t>& image = scene.plane->frame.pixels;
  ImageUpdate update;
  std::vector<double> cpu, wall;
  for (int i = 1; i <= updates; ++i) {
    std::vector<std::uint8_t> pixels(image.pixels().begin(), image.pixels().end());
    for (auto& p : pixels) p = static_cast<std::uint8_t>(p + 7 * i);
    next.plane->frame.pixels = {image.width(), image.height(), std::move(pixels)};
    next.plane->frame.sequence = scene.plane->frame.sequence + static_cast<std::uint64_t>(i);
    Result<render::RenderedImage> drawn = Error{ErrorCode::kUnavailable, "not drawn"};
    const auto taken = time_in_turn({[&]() -> Result<void> {
                                      drawn = engine->render(next);
                                      if (!drawn) return drawn.error();
                                      return {};
                                    }},
                                    {1, 0});
    if (!taken) return taken.error();
    cpu.push_back(1e3 * taken->front().cpu_s);
    wall.push_back(1e3 * taken->front().wall_s);
    update.samples = std::max(update.samples, drawn->statistics.volume_samples);
    const auto fresh = render::make_cpu_engine()->render(next);
    if (!fresh) return fresh.error();
    update.identical = update.identical && same_bytes(*drawn, *fresh);
  }
  update.cpu_ms = median(cpu);
  update.wall_ms = median(wall);
  return update;
}

Result<SkipRatio> measure_skipping(const NamedScene& named) {
  const auto engine = render::make_cpu_engine();
  render::Scene scene = named.scene;
  const auto first = engine->render(scene);
  if (!first) return first.error();
  double rays = 0;
  const double voxels = static_cast<double>(scene.ct->grid().voxel_count());
  for (int frame = 1; frame == 1 || rays < render::kRaysBeforeCells * voxels; ++frame) {
    const auto other = engine->render(nudged(scene, frame));
    if (!other) return other.error();
    rays += static_cast<double>(std::max<std::uint64_t>(other->statistics.rays, 1));
  }
  const auto on = engine->render(scene);
  if (!on) return on.error();
  scene.quality.skip_empty_bricks = false;
  const auto off = engine->render(scene);
  if (!off) return off.error();
  scene.quality.opaque_at = 1;
  const auto brute = engine->render(scene);
  if (!brute) return brute.error();
  SkipRatio found{named.name};
  found.first = first->statistics.volume_samples;
  found.on = on->statistics.volume_samples;
  found.off = off->statistics.volume_samples;
  found.brute = brute->statistics.volume_samples;
  found.identical = same_bytes(*first, *off) && same_bytes(*on, *off);
  return found;
}

Result<SkipBound> measure_skip_bound(const NamedScene& named, int repeats) {
  auto found = measure_skipping(named);
  if (!found) return found.error();
  SkipBound bound{std::move(*found), skip_oracle(named.scene),
                  std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  render::Scene off = named.scene;
  off.quality.skip_empty_bricks = false;
  MovingCamera with(named.scene);
  MovingCamera without(std::move(off));
  for (int i = 0; i <= repeats; ++i) {
    const auto taken =
        time_in_turn({[&] { return with.draw(); }, [&] { return without.draw(); }}, {1, 0});
    if (!taken) return taken.error();
    if (i == 0) continue;  // It fills the caches.
    bound.on_ms = std::min(bound.on_ms, 1e3 * (*taken)[0].cpu_s);
    bound.off_ms = std::min(bound.off_ms, 1e3 * (*taken)[1].cpu_s);
  }
  return bound;
}

Result<double> full_volume_overhead(const render::Scene& scene, const Repeats& repeats) {
  auto haze = render::TransferFunction::create(
      "haze", {{-1024, {0.6, 0.7, 0.8}, 1e-3, 1}, {3000, {1, 0.9, 0.8}, 2e-3, 1}});
  NAV_CHECK(haze.has_value());
  render::Scene on = scene;
  on.transfer = *haze;
  render::Scene off = on;
  off.quality.skip_empty_bricks = false;
  std::vector<MovingCamera> cameras;
  cameras.emplace_back(std::move(on));
  cameras.emplace_back(std::move(off));
  const auto taken = time_scenes(cameras, repeats);
  if (!taken) return taken.error();
  return (*taken)[0].cpu_s / (*taken)[1].cpu_s - 1;
}

Result<EditCost> measure_edit(const render::Scene& scene, int edits) {
  const auto engine = render::make_cpu_engine();
  if (auto first = engine->render(scene); !first) return first.error();
  std::vector<double> prepare, frame;
  for (int i = 1; i <= edits; ++i) {
    auto components = scene.transfer.components();
    for (auto& node : components.front().nodes) {
      node.opacity *= 1 - 0.01 * i;
      node.hu += i % 2 == 0 ? 3 * i : -3 * i;  // Changes which bricks show something.
    }
    auto edited = render::TransferFunction::blend(scene.transfer.name(), std::move(components));
    if (!edited) return edited.error();
    render::Scene next = scene;
    next.transfer = *edited;
    const double before = process_time_s();
    const auto image = engine->render(next);
    if (!image) return image.error();
    frame.push_back(1e3 * (process_time_s() - before));
    prepare.push_back(1e3 * image->statistics.prepare_s);
  }
  return EditCost{scene.ct->grid().size[0], median(prepare), median(frame)};
}

/// A user moves the camera and then stops, with the images shown meanwhile.
Result<void> move_and_stop(const render::Scene& scene, Interaction& found) {
  // The first images are complete, or measure the cost of coarse ones.
  constexpr int kLearning = 3;
  constexpr int kImages = 23;
  const auto engine = render::make_cpu_engine();
  render::ProgressiveRenderer renderer(*engine);
  const MonotonicClock clock;
  std::vector<double> wall_ms;
  Timestamp moved{};
  render::Scene now = scene;
  for (int i = 0; i < kImages; ++i) {
    now = nudged(scene, i);
    moved = clock.now();
    if (const auto image = renderer.draw(now, moved); !image) return image.error();
    if (i >= kLearning) wall_ms.push_back(1e3 * to_seconds(clock.now() - moved));
  }
  if (auto ok = draw_until_whole(renderer, now, clock); !ok) return ok;
  found.progressive_wall_ms = median(wall_ms);
  found.refined_ms = 1e3 * to_seconds(clock.now() - moved);
  return {};
}

Result<Interaction> measure_interaction(const NamedScene& named, const Repeats& repeats) {
  constexpr double kRms = 1e-2;
  // Odd: the middles of the reference's pixels are then middles of pixels.
  constexpr int kFactor = 5;
  Interaction found{named.name, named.scene.ct->grid().size[0]};
  render::Scene scene = named.scene;
  scene.quality.step_voxels = 0.125;
  const auto truth = render::make_reference_engine()->render(smaller(scene, kFactor));
  if (!truth) return truth.error();
  const auto engine = render::make_cpu_engine();
  render::Quality fastest = scene.quality;
  fastest.step_voxels = found.dense_step = 0.25;
  double least_s = std::numeric_limits<double>::infinity();
  found.rms = least_s;
  bool dense_found = false;
  for (const double step : {2.0, 1.75, 1.5, 1.25, 1.0, 0.75, 0.5, 0.25}) {
    // After the first sufficient step, only the next finer one can be faster.
    if (dense_found && step < 0.6 * found.dense_step) break;
    for (const double pixel_error : {0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3}) {
      scene.quality.step_voxels = step;
      scene.quality.pixel_error = pixel_error;
      const auto image = engine->render(scene);
      if (!image) return image.error();
      const double rms = render::rms_difference(middles(image->pixels, kFactor), truth->pixels);
      const bool enough = rms <= kRms;
      if (enough && pixel_error == 0 && !dense_found) {
        dense_found = true;
        found.dense_step = step;
      }
      const double took_s = image->statistics.cast_s;
      if (!(enough ? took_s < least_s : std::isinf(least_s) && rms < found.rms)) continue;
      if (enough) least_s = took_s;
      found.rms = rms;
      fastest = scene.quality;
    }
  }
  found.step = fastest.step_voxels;
  found.pixel_error = fastest.pixel_error;
  render::Scene full = named.scene;
  full.quality = fastest;
  render::Scene dense = named.scene;
  dense.quality.step_voxels = found.dense_step;
  std::vector<MovingCamera> cameras;
  cameras.emplace_back(full);
  cameras.emplace_back(std::move(dense));
  const auto taken = time_scenes(cameras, repeats);
  if (!taken) return taken.error();
  found.cpu_ms = 1e3 * (*taken)[0].cpu_s;
  found.wall_ms = 1e3 * (*taken)[0].wall_s;
  found.dense_wall_ms = 1e3 * (*taken)[1].wall_s;
  if (auto ok = move_and_stop(full, found); !ok) return ok.error();
  return found;
}

}  // namespace nav::bench
