// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/predicate_scene.hpp"

#include <limits>
#include <sstream>
#include <tuple>

#include "render/predicates/set.hpp"
#include "render/scene.hpp"

namespace nav::render {
namespace {

Error rejected_predicates(const std::string& field, const std::string& expected, double found) {
  std::ostringstream text;
  text << "predicates." << field << ": expected " << expected << ", found " << found;
  return {ErrorCode::kMalformedData, text.str()};
}

bool same_features(const Features& a, const Features& b) {
  if (a.volumes.size() != b.volumes.size() || a.labels.has_value() != b.labels.has_value()) {
    return false;
  }
  if (a.labels && a.labels->bits().data() != b.labels->bits().data()) return false;
  for (const auto& [name, volume] : a.volumes) {
    const auto other = b.volumes.find(name);
    if (other == b.volumes.end() || other->second.codes() != volume.codes()) return false;
  }
  return true;
}

bool same_shading(const std::optional<PredicateShading>& a,
                  const std::optional<PredicateShading>& b) {
  if (a.has_value() != b.has_value()) return false;
  const auto all = [](const PredicateShading& s) {
    return std::tie(s.source, s.full_gradient_per_mm, s.ambient, s.diffuse, s.specular,
                    s.shininess);
  };
  return !a || all(*a) == all(*b);
}

Result<void> check_predicate_shading(const PredicateShading& shading, const VoxelGrid& grid) {
  if (!shading.source) {
    return Error{ErrorCode::kMalformedData,
                 "predicates.shading.source: expected a volume, found none"};
  }
  const VoxelGrid& own = shading.source->grid();
  if (!(own.size == grid.size && own.spacing_mm == grid.spacing_mm &&
        own.origin_mm == grid.origin_mm && own.directions == grid.directions)) {
    return Error{ErrorCode::kMalformedData,
                 "predicates.shading.source: expected the grid of the volume, found another"};
  }
  const auto ok = validate(phong_of(shading));
  return ok ? ok : Error{ok.error().code, "predicates." + ok.error().message};
}

}  // namespace

Shading phong_of(const PredicateShading& shading) {
  Shading out;
  out.full_gradient_per_mm = shading.full_gradient_per_mm;
  out.ambient = shading.ambient;
  out.diffuse = shading.diffuse;
  out.specular = shading.specular;
  out.shininess = shading.shininess;
  return out;
}

Result<void> validate(const PredicateScene& predicates, const Scene& scene) {
  const auto& window = predicates.intensity;
  constexpr double kMost = 1e6;
  if (!(window.black >= -kMost && window.white <= kMost && window.white > window.black)) {
    return rejected_predicates("intensity.white", "a value above black within 1e6", window.white);
  }
  if (!(predicates.opacity_length_mm > 0 && predicates.opacity_length_mm <= kMost)) {
    return rejected_predicates("opacity_length_mm", "a length in (0, 1e6] mm",
                               predicates.opacity_length_mm);
  }
  if (!(predicates.cutaway_importance >= 0 && predicates.cutaway_importance <= 1)) {
    return rejected_predicates("cutaway_importance", "a number in [0, 1]",
                               predicates.cutaway_importance);
  }
  if (!(predicates.termination_error >= 0 && predicates.termination_error <= 0.5)) {
    return rejected_predicates("termination_error", "a number in [0, 0.5]",
                               predicates.termination_error);
  }
  if (predicates.scan) {
    if (const auto ok = validate(*predicates.scan, scene.ct->grid()); !ok) {
      return Error{ok.error().code, "predicates." + ok.error().message};
    }
  }
  if (predicates.shading) {
    if (const auto ok = check_predicate_shading(*predicates.shading, scene.ct->grid()); !ok) {
      return ok;
    }
  }
  const auto set = PredicateSet::create(predicates, scene.ct, position_of(scene));
  if (!set) return set.error();
  return {};
}

bool same_drawing(const PredicateScene& a, const PredicateScene& b) {
  const auto all = [](const PredicateScene& p) {
    return std::tie(p.intensity.black, p.intensity.white, p.opacity_length_mm, p.hue_mean,
                    p.cutaway_importance, p.termination_error, p.needle_lost);
  };
  return all(a) == all(b) && a.model == b.model && same_scan(a.scan, b.scan) &&
         same_features(a.features, b.features) && same_shading(a.shading, b.shading);
}

PredicatePosition position_of(const Scene& scene) {
  PredicatePosition place{scene.ct->grid(), {}, {}, {}};
  if (scene.predicates) place.scan = scene.predicates->scan;
  const bool known = scene.needle && scene.needle->safety.state <= SafetyState::kDegraded;
  if (known) {
    const NeedleShape& needle = *scene.needle;
    place.needle =
        Segment{place.grid_mm(needle.tip_ct), place.grid_mm(needle.hub_ct), needle.radius_mm};
  } else if (scene.needle || (scene.predicates && scene.predicates->needle_lost)) {
    const Eigen::Vector3d nowhere =
        Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    place.needle = Segment{nowhere, nowhere, 0};
  }
  if (!scene.spheres.empty()) {
    const Eigen::Vector3d centre = place.grid_mm(scene.spheres.front().centre_ct);
    place.target = Segment{centre, centre, scene.spheres.front().radius_mm};
  }
  return place;
}

}  // namespace nav::render
