// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/refinement.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "render/quality/sparse_rays.hpp"
#include "render/scene_compare.hpp"

namespace nav::render {
namespace {

constexpr auto kOfView = static_cast<std::size_t>(SceneChange::kView);

}  // namespace

Scene with_fewer_pixels(Scene scene, int factor) {
  scene.width = (scene.width + factor - 1) / factor;
  scene.height = (scene.height + factor - 1) / factor;
  return scene;
}

Refinement::Refinement(const ProgressiveOptions& options) : options_(options) {
  NAV_CHECK(options.budget_s >= 0 && options.refine_after_s >= 0, options.budget_s,
            options.refine_after_s);
  NAV_CHECK(options.coarse_pixel_error >= 0 && options.coarse_pixel_error <= 1,
            options.coarse_pixel_error);
  NAV_CHECK(options.coarse_factor >= 2 && options.coarse_factor <= 8, options.coarse_factor);
  NAV_CHECK(options.largest_factor >= options.coarse_factor && options.largest_factor <= 8,
            options.largest_factor);
}

/// The least factor that keeps to the budget if all pixels take this long.
int Refinement::small_factor(double all_pixels_s) const {
  int factor = options_.coarse_factor;
  while (factor < options_.largest_factor && all_pixels_s > options_.budget_s * factor * factor) {
    ++factor;
  }
  return factor;
}

/// Makes a plan coarse. changed: the scene has changed since the last image; otherwise the image
/// keeps its number of pixels.
void Refinement::give_up(Asked& asked, double whole_s, double dearer, bool changed) const {
  Plan& plan = asked.plan;
  double& pixel_error = plan.scene.quality.pixel_error;
  pixel_error = std::max(pixel_error, options_.coarse_pixel_error);
  asked.sparse = sparse_rays(plan.scene) && pixel_error > asked.scene.quality.pixel_error;
  if (!changed) {
    plan.factor = drawn_->plan.factor;
    return;
  }
  const double share = asked.sparse ? sparse_share_ : 1;
  if (share * whole_s <= options_.budget_s) return;
  plan.factor = small_factor(all_pixels_s_ > 0 ? dearer * all_pixels_s_ : share * whole_s);
}

Refinement::Plan Refinement::plan(const Scene& scene, Timestamp now) {
  const auto since_drawn = [&](const Scene& next) {
    if (!drawn_) return SceneChange::kView;
    return change_between(with_fewer_pixels(drawn_->plan.scene, drawn_->plan.factor), next);
  };
  const bool changed = !drawn_ || change_between(drawn_->scene, scene) >= SceneChange::kGeometry;
  if (changed) changed_ = now;
  const double dearer = drawn_ && !asks_same_predicates(drawn_->scene, scene) ? kAnotherSet : 1;
  const auto cost = static_cast<std::size_t>(since_drawn(scene));
  const double whole_s = dearer * cost_s_[cost];
  const bool needed = changed || wants_refinement();
  planned_ =
      Asked{.scene = scene, .plan = {scene, 1, true}, .cost = cost, .anew = false, .sparse = false};
  Plan& plan = planned_->plan;
  const bool in_motion = needed && !is_still(now);
  plan.refined = !in_motion || whole_s <= options_.budget_s;
  // However fast the rays are, an image may have to wait while its engine prepares data.
  plan.scene.quality.provisional = in_motion && std::isfinite(options_.budget_s);
  if (!plan.refined) give_up(*planned_, whole_s, dearer, changed);
  // The cost of a new image cannot be learnt if the engine may have kept parts of the last one.
  planned_->anew = since_drawn(with_fewer_pixels(plan.scene, plan.factor)) == SceneChange::kView;
  return plan;
}

void Refinement::drawn(double took_s, int factor, bool provisional) {
  NAV_CHECK(planned_ && took_s >= 0 && factor >= 1 && factor <= planned_->plan.factor, took_s,
            factor);
  const bool after_coarse = wants_refinement();
  const bool same_set = !drawn_ || asks_same_predicates(drawn_->scene, planned_->scene);
  drawn_ = std::exchange(planned_, std::nullopt);
  drawn_->plan.factor = factor;
  if (provisional) drawn_->plan.refined = false;
  // Only the expected cost of a view is known for another predicate set.
  if (!same_set) cost_s_ = {0, 0, 0, kAnotherSet * cost_s_[kOfView]};
  const double whole_s = cost_s_[drawn_->cost];
  if (drawn_->plan.refined) {
    learn_whole(took_s, after_coarse);
  } else if (drawn_->anew && factor > 1) {
    all_pixels_s_ = took_s * factor * factor;
  } else if (drawn_->anew && drawn_->sparse && whole_s > 0) {
    sparse_share_ = took_s / whole_s;
  }
}

void Refinement::learn_whole(double took_s, bool after_coarse) {
  if (after_coarse) {
    for (double& cost_s : cost_s_) cost_s *= kFading;
    sparse_share_ *= kFading;
  }
  cost_s_[drawn_->cost] = took_s;
}

}  // namespace nav::render
