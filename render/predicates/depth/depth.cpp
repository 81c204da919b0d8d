// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "render/predicates/feature.hpp"
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// The depth of a half-space is normal · position + offset, in grid mm.
struct Slab {
  Eigen::Vector3d normal;
  double offset;
};

Slab slab_of(const ParallelScan& scan, const PredicatePosition& place) {
  const Eigen::Vector3d normal =
      place.grid.directions.transpose() * scan.into_ct.v.stableNormalized();
  return {normal, -normal.dot(place.grid_mm(scan.face_ct))};
}

Segment ball_of(const FanScan& scan, const PredicatePosition& place) {
  const Eigen::Vector3d apex = place.grid_mm(scan.apex_ct);
  return {apex, apex, scan.face_radius_mm};
}

/// Depth along the scan line. It is exact for a fan or parallel lines; otherwise it comes from the
/// feature volume.
class Depth final : public PredicateKind {
 public:
  [[nodiscard]] std::string name() const override { return "depth"; }
  [[nodiscard]] std::string description() const override {
    return "Distance from the probe's face along the scan line, within a range.";
  }
  [[nodiscard]] std::vector<PredicateParameter> parameters() const override {
    return {{.name = "low_mm", .unit = "mm", .low = -1e4, .high = 1e4, .initial = 0},
            {.name = "high_mm", .unit = "mm", .low = -1e4, .high = 1e4, .initial = 30}};
  }
  [[nodiscard]] PredicateNeeds needs(const PredicatePosition& place) const override {
    PredicateNeeds needs;
    needs.scan = true;
    if (place.scan && std::holds_alternative<VoxelScan>(*place.scan)) {
      needs.channels = {feature::kDepth};
    } else {
      needs.position = true;
    }
    return needs;
  }
  [[nodiscard]] Result<void> check(std::span<const double> p) const override {
    return check_order(*this, p, 0, 1);
  }
  [[nodiscard]] bool test(const PredicateSample& s, const PredicatePosition& place,
                          std::span<const double> p) const override {
    if (const auto* parallel = std::get_if<ParallelScan>(&*place.scan)) {
      const Slab slab = slab_of(*parallel, place);
      const double depth = slab.normal.dot(s.position_mm) + slab.offset;
      return depth >= p[0] && depth <= p[1];
    }
    if (const auto* fan = std::get_if<FanScan>(&*place.scan)) {
      return test_distance(ball_of(*fan, place), s.position_mm, wanted_range(p));
    }
    return feature_.test(s, place, p);
  }
  [[nodiscard]] Truth bounds(const PredicateBounds& b, const PredicatePosition& place,
                             std::span<const double> p) const override {
    if (const auto* parallel = std::get_if<ParallelScan>(&*place.scan)) {
      const Slab slab = slab_of(*parallel, place);
      const double middle = slab.normal.dot(0.5 * (b.low_mm + b.high_mm)) + slab.offset;
      const double reach = slab.normal.cwiseAbs().dot(0.5 * (b.high_mm - b.low_mm));
      return within({middle - reach, middle + reach}, wanted_range(p));
    }
    if (const auto* fan = std::get_if<FanScan>(&*place.scan)) {
      return bound_distance(ball_of(*fan, place), b.low_mm, b.high_mm, wanted_range(p));
    }
    return feature_.bounds(b, place, p);
  }
  [[nodiscard]] PredicateForm form(const PredicatePosition& place,
                                   std::span<const double> p) const override {
    if (const auto* parallel = std::get_if<ParallelScan>(&*place.scan)) {
      const Slab slab = slab_of(*parallel, place);
      PredicateForm form;
      form.kind = PredicateForm::Kind::kSlab;
      form.low = p[0] - slab.offset;
      form.high = p[1] - slab.offset;
      form.a = slab.normal;
      return form;
    }
    if (const auto* fan = std::get_if<FanScan>(&*place.scan)) {
      return distance_form(ball_of(*fan, place), wanted_range(p));
    }
    return feature_.form(place, p);
  }
  [[nodiscard]] PredicateGlsl glsl(const std::string& prefix, const PredicatePosition& place,
                                   std::span<const double> p) const override {
    if (const auto* parallel = std::get_if<ParallelScan>(&*place.scan)) {
      const Slab slab = slab_of(*parallel, place);
      const std::string depth = "dot(" + prefix + "_normal, POSITION)";
      return {
          "uniform vec3 " + prefix + "_normal;\nuniform vec2 " + prefix + "_range;\n",
          "(" + depth + " >= " + prefix + "_range.x && " + depth + " <= " + prefix + "_range.y)",
          {{prefix + "_normal", {slab.normal.x(), slab.normal.y(), slab.normal.z()}},
           {prefix + "_range", {p[0] - slab.offset, p[1] - slab.offset}}}};
    }
    if (const auto* fan = std::get_if<FanScan>(&*place.scan)) {
      return distance_glsl(prefix, ball_of(*fan, place), wanted_range(p));
    }
    return feature_.glsl(prefix, place, p);
  }

 private:
  RangePredicate feature_{"depth", description(), feature::kDepth, parameters()};
};

}  // namespace

const PredicateKind& depth_predicate() {
  static const Depth kind;
  return kind;
}

}  // namespace nav::render
