// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/predicate_frames.hpp"
#include "bench/until_whole.hpp"
#include "render/gl/gl_raycaster.hpp"

namespace nav::bench {

/// What a user waits for after another set of predicates, wall time, ms.
struct ProgressiveEdit {
  double first_ms = 0;       ///< To the first picture as render::ProgressiveRenderer draws it.
  bool provisional = false;  ///< That picture: render::RenderStatistics::provisional.
  double whole_ms = 0;       ///< To the first whole one.
};

/// A set that reads nothing but the volume: whatever a scene reads besides is new to its engine.
inline render::Scene plain_set(render::Scene scene) {
  render::PredicateModel& model = scene.predicates->model;
  model.entries = {{"plain", render::PredicateExpression::kind("intensity", {0.123, 0.987})}};
  model.histogram = *render::PredicateHistogram::create({{1, 100, 0.5}});
  return scene;
}

/// On an engine that has drawn nothing yet: a user has looked at the other set from several sides.
inline Result<ProgressiveEdit> time_progressive_edit(render::Engine& fresh,
                                                     const render::Scene& scene,
                                                     const render::Scene& other_set) {
  constexpr int kLooks = 2 * render::GlRaycaster::kSettledAfter;
  render::ProgressiveRenderer renderer(fresh);
  const MonotonicClock clock;
  for (int i = 0; i < kLooks; ++i) {
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
