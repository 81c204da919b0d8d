// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/render/predicates/predicate_scenes.hpp"

/// Scenes with one predicate. All values that the middle ray meets lie at an end of the range of
/// the predicate.
namespace nav::test {

struct EdgeCase {
  std::string name;
  render::Scene scene;
  bool seen;  ///< In the middle of the image the volume is either completely visible or completely
              ///< invisible.
};

/// Scene seen along +y from far away, orthographic.
inline render::Scene edge_scene(std::shared_ptr<const StoredVolume> ct,
                                const render::PredicateExpression& expression) {
  render::Scene scene = plain_scene(std::move(ct), fog(0.1), frontal(80, 10, true));
  scene.predicates.emplace();
  scene.predicates->model = model_of({{expression, 1}});
  scene.predicates->termination_error = 0;
  return scene;
}

/// Returns the scene with a predicate that is true everywhere.
inline render::Scene without_condition(render::Scene scene) {
  scene.predicates->model =
      model_of({{render::PredicateExpression::kind("intensity", {-1e6, 1e6}), 1}});
  return scene;
}

/// A ramp exactly along the scan line, beside noise whose gradients have every size and angle.
inline std::vector<EdgeCase> angle_cases() {
  using E = render::PredicateExpression;
  struct Wanted {
    double low_deg, high_deg;
    bool with_depth, against;  ///< Expected visibility of a ramp that gets brighter with depth, and
                               ///< of the opposite ramp.
  };
  std::mt19937 random(12);
  const auto ct = make_volume(centred_grid({41, 31, 31}, {1, 1, 1}), [&](int i, int j, int) {
    return i < 30 ? 40.0 + 3 * j : static_cast<double>(random() % 256);
  });
  std::vector<EdgeCase> out;
  for (const Wanted& w : {Wanted{0, 20, true, false},
                          {0, 180, true, true},
                          {0, 0, true, false},
                          {0, 1e-3, true, false},
                          {160, 180, false, true},
                          {180, 180, false, true},
                          {20, 160, false, false}}) {
    for (const bool with_depth : {true, false}) {
      render::Scene scene = edge_scene(
          ct, E::kind("gradient_angle", {w.low_deg * M_PI / 180, w.high_deg * M_PI / 180, 1e-3}));
      scene.predicates->scan = render::ParallelScan{{{0, 0, 0}}, {{0, with_depth ? 1.0 : -1.0, 0}}};
      EXPECT_TRUE(has_value(add_features(ct, 0, *scene.predicates)));
      out.push_back({std::to_string(w.low_deg) + " to " + std::to_string(w.high_deg) + " deg, " +
                         (with_depth ? "brighter" : "darker") + " with depth",
                     std::move(scene), with_depth ? w.with_depth : w.against});
    }
  }
  return out;
}

/// Features that are constant everywhere.
inline std::vector<EdgeCase> constant_cases() {
  using E = render::PredicateExpression;
  struct Wanted {
    float value;
    double low, high;
    bool seen;
  };
  const VoxelGrid grid = centred_grid({21, 21, 21}, {1, 1, 1});
  const auto ct = make_volume(grid, [](int, int, int) { return 90; });
  std::vector<EdgeCase> out;
  for (const Wanted& w : {Wanted{0, 0.15, 1, false},
                          {0, 1e-6, 1, false},
                          {0, 0, 1, true},
                          {0, 0, 0, true},
                          {1, 0, 0.999, false},
                          {1, 1, 1, true},
                          {0.1F, 0, 0.1, true},
                          {0.1F, 0.1, 1, true},
                          {0.1F, 0.10001, 1, false},
                          {0.1F, 0, 0.09999, false}}) {
    render::Scene scene = edge_scene(ct, E::kind("vesselness", {w.low, w.high}));
    scene.predicates->features.volumes.emplace(
        render::feature::kVesselness,
        feature(grid, render::feature::kVesselness,
                [&](int, int, int) { return static_cast<double>(w.value); }));
    out.push_back({"constant " + std::to_string(w.value) + " in [" + std::to_string(w.low) + ", " +
                       std::to_string(w.high) + "]",
                   std::move(scene), w.seen});
  }
  return out;
}

}  // namespace nav::test
