// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_predicates.hpp"

#include <algorithm>
#include <cmath>

#include "render/reference/reference_gradient.hpp"

namespace nav::render {

ReferencePredicates::ReferencePredicates(const Scene& scene)
    : scene_(scene),
      set_(*PredicateSet::create(*scene.predicates, scene.ct, position_of(scene))),
      sampler_(set_),
      opacity_(scene.predicates->opacity_length_mm),
      overlay_mm_(scene.cutaway ? scene.cutaway->overlay_mm : 0),
      cutaway_(scene.cutaway.value_or(Cutaway{})),
      step_mm_(spec::step_mm(scene.quality, scene.ct->grid())) {}

spec::ImportanceState<double> ReferencePredicates::cast(const Ray& ray,
                                                        std::uint64_t& samples) const {
  spec::ImportanceState<double> state;
  const spec::Ray<double> index = spec::index_ray(ray.ray, scene_.ct->grid());
  double begin = ray.in.begin;
  for (const auto& hit : ray.hits) {
    march(ray, index, {begin, std::min(ray.in.end, hit.t)}, state, samples);
    spec::composite_log(state, hit.rgb, hit.alpha, set_.greatest_impact());
    begin = std::max(ray.in.begin, hit.t);
  }
  march(ray, index, {begin, ray.in.end}, state, samples);
  return state;
}

void ReferencePredicates::march(const Ray& ray, ImageScale stretch,
                                spec::ImportanceState<double>& state,
                                std::uint64_t& samples) const {
  const ImageScale inside{std::max(stretch.begin, ray.in.begin), std::min(stretch.end, ray.in.end)};
  march(ray, spec::index_ray(ray.ray, scene_.ct->grid()), inside, state, samples);
}

void ReferencePredicates::march(const Ray& ray, const spec::Ray<double>& index, ImageScale stretch,
                                spec::ImportanceState<double>& state,
                                std::uint64_t& samples) const {
  if (!(stretch.end > stretch.begin)) return;
  const double h = step_mm_;
  for (double k = std::floor(stretch.begin / h - ray.shift); (k + ray.shift) * h < stretch.end;
       k += 1) {
    const ImageScale part{std::max((k + ray.shift) * h, stretch.begin),
                          std::min((k + 1 + ray.shift) * h, stretch.end)};
    if (!(part.end > part.begin)) continue;
    ++samples;
    add(ray, index.origin + (k + 0.5 + ray.shift) * h * index.direction, part, state);
  }
}

void ReferencePredicates::add(const Ray& ray, const Eigen::Vector3d& middle, ImageScale part,
                              spec::ImportanceState<double>& state) const {
  const double intensity = std::clamp(sampler_.value(0, middle), 0.0, 1.0);
  double tau = opacity_.tau(intensity);
  if (!(tau > 0)) return;
  const spec::PredicateClass c = set_.class_of(sampler_.mask(middle));
  if (!(c.importance > 0)) return;
  if (part.begin < ray.span.t2) {
    const double importance = spec::full_importance(scene_.predicates->cutaway_importance *
                                                    c.importance / set_.greatest_impact());
    double visible = 0;
    for (int j = 0; j < spec::kFadeSteps; ++j) {
      const double t = part.begin + (j + 0.5) / spec::kFadeSteps * (part.end - part.begin);
      visible += spec::visibility(cutaway_, importance, spec::occlusion(ray.span, overlay_mm_, t));
    }
    tau = spec::faded(tau, visible / spec::kFadeSteps);
  }
  spec::Rgb<double> rgb = spec::hsl(spec::hsl_tint(c.hue_deg, c.saturation), intensity);
  if (const auto& shading = scene_.predicates->shading) {
    rgb = spec::shade_sample<double>(rgb, reference_gradient(*shading->source, middle),
                                     ray.ray.direction, spec::Vec3<double>::Zero(), 1.0,
                                     phong_of(*shading));
  }
  spec::composite_log(state, rgb, -std::expm1(-tau * (part.end - part.begin)), c.importance);
}

}  // namespace nav::render
