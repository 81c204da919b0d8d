// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/predicates/predicate_sampler.hpp"
#include "render/predicates/set.hpp"
#include "render/scene.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// Renders rays by predicates in double precision. It holds the data that all rays of an image
/// share. Thread-safe.
class ReferencePredicates {
 public:
  /// Precondition: the scene is validated, has predicates, and outlives this object.
  explicit ReferencePredicates(const Scene& scene);

  struct Ray {
    spec::Ray<double> ray;
    spec::Interval<double> in;  ///< Part inside the volume.
    double shift;               ///< Shift of the cells, spec::jitter_of().
    spec::CutawaySpan<double> span;
    const std::vector<spec::Hit<double>>& hits;
  };
  /// Composites every cell and every surface of a ray. Adds the number of samples to \p samples.
  [[nodiscard]] spec::ImportanceState<double> cast(const Ray& ray, std::uint64_t& samples) const;

  /// Part of a ray, mm; empty when end <= begin.
  struct ImageScale {
    double begin;
    double end;
  };
  /// Composites the cells of a part of the ray, as far as it lies in the volume.
  void march(const Ray& ray, ImageScale stretch, spec::ImportanceState<double>& state,
             std::uint64_t& samples) const;
  [[nodiscard]] double greatest_impact() const { return set_.greatest_impact(); }

 private:
  void march(const Ray& ray, const spec::Ray<double>& index, ImageScale stretch,
             spec::ImportanceState<double>& state, std::uint64_t& samples) const;
  void add(const Ray& ray, const Eigen::Vector3d& middle, ImageScale part,
           spec::ImportanceState<double>& state) const;

  const Scene& scene_;
  PredicateSet set_;
  PredicateSampler sampler_;
  IntensityOpacity opacity_;
  double overlay_mm_;
  Cutaway cutaway_;  ///< For its thresholds.
  double step_mm_;
};

}  // namespace nav::render
