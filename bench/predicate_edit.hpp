// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/predicate_frames.hpp"
#include "bench/until_whole.hpp"
#include "render/gl/gl_raycaster.hpp"

namespace nav::bench {

/// Waiting time of a user after a change of the predicate set, wall time, ms.
struct ProgressiveEdit {
  double first_ms = 0;       ///< Until the first image from render::ProgressiveRenderer.
  bool provisional = false;  ///< RenderStatistics::provisional of that image.
  double whole_ms = 0;       ///< Until the first complete image.
};

/// A predicate set that reads only the volume: all other data of a scene is then new to its engine.
inline render::Scene plain_set(render::Scene scene) {
  render::PredicateModel& model = scene.predicates->model;
  model.entries = {{"plain", render::PredicateExpression::kind("intensity", {0.123, 0.987})}};
  model.histogram = *render::PredicateHistogram::create({{1, 100, 0.5}});
  return scene;
}

/// Measures on an engine that has drawn nothing yet: first draws the other set from several sides,
/// as a user would.
inline Result<ProgressiveEdit> time_progressive_edit(render::Engine& fresh,
                                                     const render::Scene& scene,
                                                     const render::Scene& other_set) {
  constexpr int kAppearances = 2 * render::GlRaycaster::kSettledAfter;
  render::ProgressiveRenderer renderer(fresh);
  const MonotonicClock clock;
  for (int i = 0; i < kAppearances; ++i) {
    if (auto ok = renderer.draw(nudged(other_set, i), clock.now()); !ok) return ok.error();
  }
  if (auto ok = draw_until_whole(renderer, other_set, clock); !ok) return ok.error();
  ProgressiveEdit edit;
  const Timestamp edited = clock.now();
  const auto first = renderer.draw(scene, edited);
  if (!first) return first.error();
  edit.first_ms = 1e3 * to_seconds(clock.now() - edited);
  edit.provisional = first->image.statistics.provisional;
  if (auto ok = draw_until_whole(renderer, scene, clock); !ok) return ok.error();
  edit.whole_ms = 1e3 * to_seconds(clock.now() - edited);
  return edit;
}

}  // namespace nav::bench
