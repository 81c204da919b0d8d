// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/visible_point.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "render/reference/reference_predicates.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"
#include "render/two_volumes.hpp"

namespace nav::render {
namespace {

constexpr double kLeastVisible = 0.02;
/// Steps of a ray are at most this many.
constexpr int kMostSteps = 20000;

/// Light that is absorbed along a ray: distance, mm, and the share absorbed up to there.
using Absorbed = std::vector<std::pair<double, double>>;

/// Volume drawn by the transfer function, with its cutaway.
Absorbed through_ct(const Scene& scene, const spec::Ray<double>& ray,
                    const spec::CutawaySpan<double>& span) {
  const VoxelGrid& grid = scene.ct->grid();
  const spec::Ray<double> index = spec::index_ray(ray, grid);
  const spec::Interval<double> in = spec::clip_to_box(index, grid.size);
  const double step = std::max(0.5 * grid.spacing_mm.minCoeff(), (in.end - in.begin) / kMostSteps);
  Absorbed absorbed;
  double left = 1;
  for (double t = in.begin; t < in.end; t += step) {
    const double middle = t + 0.5 * step;
    const double value = spec::value_at(*scene.ct, index.origin + middle * index.direction);
    const TransferSample sample = scene.transfer.at(value);
    double tau = sample.tau_per_mm;
    if (scene.cutaway && tau > 0) {
      const double omega = spec::occlusion(span, scene.cutaway->overlay_mm, middle);
      tau = spec::faded(
          tau, spec::visibility(*scene.cutaway, spec::full_importance(sample.importance), omega));
    }
    if (!(tau > 0)) continue;
    left *= std::exp(-tau * step);
    absorbed.emplace_back(middle, 1 - left);
  }
  return absorbed;
}

/// Volume drawn by predicates.
Absorbed through_predicates(const Scene& scene, const spec::Ray<double>& ray,
                            const spec::CutawaySpan<double>& span) {
  const ReferencePredicates predicates(scene);
  const VoxelGrid& grid = scene.ct->grid();
  const spec::Interval<double> in = spec::clip_to_box(spec::index_ray(ray, grid), grid.size);
  const std::vector<spec::Hit<double>> none;
  const ReferencePredicates::Ray cast{.ray = ray, .in = in, .shift = 0, .span = span, .hits = none};
  const double step =
      std::max(spec::step_mm(scene.quality, grid), (in.end - in.begin) / kMostSteps);
  Absorbed absorbed;
  spec::ImportanceState<double> light;
  std::uint64_t samples = 0;
  for (double t = in.begin; t < in.end; t += step) {
    const double before = light.alpha;
    predicates.march(cast, {t, std::min(t + step, in.end)}, light, samples);
    if (light.alpha > before) absorbed.emplace_back(t + 0.5 * step, light.alpha);
  }
  return absorbed;
}

/// One curve of two: the light that passes both.
Absorbed both_of(const Absorbed& a, const Absorbed& b) {
  Absorbed both;
  double a_left = 1;
  double b_left = 1;
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    const bool first = j >= b.size() || (i < a.size() && a[i].first <= b[j].first);
    const double t = first ? a[i].first : b[j].first;
    if (first) {
      a_left = 1 - a[i++].second;
    } else {
      b_left = 1 - b[j++].second;
    }
    both.emplace_back(t, 1 - a_left * b_left);
  }
  return both;
}

Absorbed by_surfaces(const Scene& scene, const spec::Ray<double>& ray) {
  std::vector<spec::Hit<double>> hits;
  Surfaces(scene).meet(ray, hits);
  Absorbed absorbed;
  double left = 1;
  for (const auto& hit : hits) {
    left *= 1 - hit.alpha;
    absorbed.emplace_back(hit.t, 1 - left);
  }
  return absorbed;
}

}  // namespace

Result<std::optional<Point<frames::Ct>>> visible_point(const Scene& scene, int x, int y) {
  using Found = std::optional<Point<frames::Ct>>;
  if (auto ok = validate(scene); !ok) return ok.error();
  if (x < 0 || y < 0 || x >= scene.width || y >= scene.height) return Found();
  const auto ray_in = [&](const VoxelGrid& grid) {
    return spec::ray_of(spec::make_view<double>(scene.camera, scene.width, scene.height, grid), x,
                        y);
  };
  const spec::Ray<double> ray = ray_in(scene.ct->grid());
  const spec::CutawaySpan<double> span = spec::meet_cutaway(spec::make_cutaway(scene, true), ray);
  Absorbed absorbed =
      scene.predicates ? through_predicates(scene, ray, span) : through_ct(scene, ray, span);
  if (scene.ultrasound) {
    const Scene second = ultrasound_scene(scene);
    absorbed = both_of(absorbed, through_predicates(second, ray_in(second.ct->grid()), span));
  }
  absorbed = both_of(absorbed, by_surfaces(scene, ray));
  if (absorbed.empty() || absorbed.back().second < kLeastVisible) return Found();
  const double half = 0.5 * absorbed.back().second;
  const auto at = std::ranges::find_if(absorbed, [&](const auto& p) { return p.second >= half; });
  return Found(
      Point<frames::Ct>{scene.ct->grid().origin_mm + ray.origin + at->first * ray.direction});
}

}  // namespace nav::render
