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

}  // namespace

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
         same_features(a.features, b.features);
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
