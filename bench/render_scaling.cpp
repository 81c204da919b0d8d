// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_scaling.hpp"

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {
namespace {

Result<render::Scene> scene_of(std::shared_ptr<const Volume> ct,
                               const render::TransferFunction& transfer, int width, int height) {
  const auto scenes =
      bench_scenes({{"patient", std::move(ct), {transfer}}}, "perspective/shaded", width, height);
  NAV_CHECK(scenes.size() == 1);
  return scenes.front().scene;
}

/// Tissue above a value, opaque enough to be visible; the lower the value, the fuller the volume.
render::TransferFunction above(double hu) {
  auto made = render::TransferFunction::create("above " + std::to_string(std::lround(hu)),
                                               {{hu, {0.9, 0.7, 0.6}, 0, 1},
                                                {hu + 20, {0.9, 0.7, 0.6}, 0.01, 1},
                                                {hu + 400, {1, 0.95, 0.9}, 0.1, 1}});
  NAV_CHECK(made.has_value());
  return *made;
}

Result<ScalingPoint> measure(const std::string& axis, double x, const render::Scene& scene,
                             int threads, const Repeats& repeats) {
  ScalingPoint point{axis, scene.transfer.name(), x};
  const std::size_t before = resident_bytes();
  const auto engine = render::make_cpu_engine({threads});
  const auto first = engine->render(scene);
  if (!first) return first.error();
  const std::size_t after = resident_bytes();
  point.prepare_ms = 1e3 * first->statistics.prepare_s;
  point.samples = first->statistics.volume_samples;
  point.occupied = static_cast<double>(first->statistics.bricks_occupied) /
                   static_cast<double>(std::max<std::uint64_t>(first->statistics.bricks, 1));
  point.bytes_per_voxel = std::numeric_limits<double>::quiet_NaN();
  if (axis == "side") {
    // The image is not part of the structures.
    const double pixels = 16.0 * scene.width * scene.height;
    const double taken = static_cast<double>(after) - static_cast<double>(before) - pixels;
    point.bytes_per_voxel =
        std::max(taken, 0.0) / static_cast<double>(scene.ct->grid().voxel_count());
  }
  int frame = 0;
  const auto taken = time_in_turn({[&]() -> Result<void> {
                                    auto image = engine->render(nudged(scene, ++frame));
                                    if (!image) return image.error();
                                    return {};
                                  }},
                                  repeats);
  if (!taken) return taken.error();
  point.cpu_ms = 1e3 * taken->front().cpu_s;
  point.wall_ms = 1e3 * taken->front().wall_s;
  return point;
}

/// One point to measure; its volume is made only when it is needed.
struct Plan {
  std::string axis;
  double x;
  int side;
  render::TransferFunction transfer;
  int width;
  int height;
  int threads = 0;
};

std::vector<Plan> plans(const ScalingOptions& o) {
  const auto bone = render::preset_transfer_function("ct-bone");
  const auto vessels = render::preset_transfer_function("cta-vessels");
  NAV_CHECK(bone.has_value() && vessels.has_value());
  std::vector<Plan> all;
  for (const int side : o.sides) {
    all.push_back({.axis = "side",
                   .x = 1.0 * side,
                   .side = side,
                   .transfer = *bone,
                   .width = o.width,
                   .height = o.height});
    all.push_back({.axis = "side",
                   .x = 1.0 * side,
                   .side = side,
                   .transfer = *vessels,
                   .width = o.width,
                   .height = o.height});
  }
  for (const double scale : {0.25, 0.5, 1.0, 1.5, 2.0}) {
    const int width = static_cast<int>(o.width * scale);
    const int height = static_cast<int>(o.height * scale);
    all.push_back({.axis = "pixels",
                   .x = 1.0 * width * height,
                   .side = o.side,
                   .transfer = *vessels,
                   .width = width,
                   .height = height});
  }
  for (const int threads : {1, 2}) {
    all.push_back({.axis = "threads",
                   .x = 1.0 * threads,
                   .side = o.side,
                   .transfer = *vessels,
                   .width = o.width,
                   .height = o.height,
                   .threads = threads});
  }
  for (const double hu : {900.0, 450.0, 250.0, 180.0, 140.0, 100.0, 40.0, -150.0, -1100.0}) {
    all.push_back({.axis = "occupied",
                   .x = 0,
                   .side = o.side,
                   .transfer = above(hu),
                   .width = o.width,
                   .height = o.height});
  }
  return all;
}

}  // namespace

Result<std::vector<ScalingPoint>> measure_scaling(const ScalingOptions& options,
                                                  const std::function<void(double)>& progress) {
  std::vector<ScalingPoint> points;
  std::shared_ptr<const Volume> ct;
  const std::vector<Plan> all = plans(options);
  for (const Plan& plan : all) {
    if (!ct || ct->grid().size[0] != plan.side) {
      ct.reset();  // Released before the next is made: two of the largest may not fit in memory.
      auto made = cubic_patient(plan.side);
      if (!made) return made.error();
      ct = std::move(*made);
    }
    const auto scene = scene_of(ct, plan.transfer, plan.width, plan.height);
    if (!scene) return scene.error();
    auto point = measure(plan.axis, plan.x, *scene, plan.threads, options.repeats);
    if (!point) return point.error();
    if (plan.axis == "occupied") point->x = point->occupied;
    points.push_back(std::move(*point));
    if (progress) {
      progress(static_cast<double>(points.size()) / static_cast<double>(all.size()));
    }
  }
  return points;
}

std::string to_text(const std::vector<ScalingPoint>& points) {
  std::ostringstream out;
  out << std::left << std::setw(10) << "axis" << std::setw(14) << "look" << std::right
      << std::setw(12) << "x" << std::setw(10) << "cpu ms" << std::setw(10) << "wall ms"
      << std::setw(12) << "prepare ms" << std::setw(12) << "samples" << std::setw(10) << "occupied"
      << std::setw(14) << "bytes/voxel" << '\n'
      << std::fixed;
  for (const ScalingPoint& p : points) {
    out << std::left << std::setw(10) << p.axis << std::setw(14) << p.appearance << std::right
        << std::setprecision(p.axis == "occupied" ? 3 : 0) << std::setw(12) << p.x
        << std::setprecision(1) << std::setw(10) << p.cpu_ms << std::setw(10) << p.wall_ms
        << std::setw(12) << p.prepare_ms << std::setw(12) << p.samples << std::setprecision(3)
        << std::setw(10) << p.occupied;
    if (std::isfinite(p.bytes_per_voxel)) out << std::setw(14) << p.bytes_per_voxel;
    out << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
