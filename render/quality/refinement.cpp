// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/refinement.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "render/quality/sparse_rays.hpp"

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
  NAV_CHECK(options.finer_after_s >= 0 && options.finer_step_s >= 0, options.finer_after_s,
            options.finer_step_s);
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

/// The factor of a coarse image whose view is that of the last one, in which objects moved.
/// for_view: the factor if all rays had to be cast.
int Refinement::factor_at_rest(int for_view, Timestamp now) const {
  const int last = drawn_->plan.factor;
  if (drawn_->plan.refined || kept_pixels_s_ <= 0) return for_view;
  const auto kept_fits = [&](int factor, double share) {
    return kept_pixels_s_ <= share * options_.budget_s * factor * factor;
  };
  constexpr double kStay = 1.25;  // Changing the factor costs all rays once, so it is not changed
  constexpr double kGoFiner = 0.75;  // to and fro.
  if (to_seconds(now - view_changed_) >= options_.finer_after_s) {
    for (int factor = 1; factor < last; ++factor) {
      const bool soon = all_pixels_s_ <= options_.finer_step_s * factor * factor;
      if (soon && kept_fits(factor, kGoFiner)) return factor;
    }
  }
  if (kept_fits(last, kStay)) return std::min(last, for_view);
  int factor = std::min(last, for_view);
  while (factor < for_view && !kept_fits(factor, 1)) ++factor;
  return factor;
}

/// Makes a plan coarse. change: from the last scene; without one the image keeps its number of
/// pixels.
void Refinement::give_up(Asked& asked, double whole_s, double dearer, SceneChange change,
                         Timestamp now) const {
  Plan& plan = asked.plan;
  double& pixel_error = plan.scene.quality.pixel_error;
  pixel_error = std::max(pixel_error, options_.coarse_pixel_error);
  asked.sparse = sparse_rays(plan.scene) && pixel_error > asked.scene.quality.pixel_error;
  if (change < SceneChange::kGeometry) {
    plan.factor = drawn_->plan.factor;
    return;
  }
  const double share = asked.sparse ? sparse_share_ : 1;
  if (share * whole_s <= options_.budget_s && !interrupted_) {
    // Nothing is known yet: the attempt may last nearly as long as an image in full.
    if (asked.sparse && sparse_share_ <= 0) plan.yields_to = SceneChange::kGeometry;
    return;
  }
  plan.factor = small_factor(all_pixels_s_ > 0 ? dearer * all_pixels_s_ : share * whole_s);
  if (change != SceneChange::kGeometry || interrupted_) return;
  const int at_rest = factor_at_rest(plan.factor, now);
  const bool finer = at_rest < drawn_->plan.factor;
  plan.factor = at_rest;
  if (finer) plan.yields_to = SceneChange::kView;
}

Refinement::Plan Refinement::plan(const Scene& scene, Timestamp now) {
  const auto since_drawn = [&](const Scene& next) {
    if (!drawn_) return SceneChange::kView;
    return change_between(with_fewer_pixels(drawn_->plan.scene, drawn_->plan.factor), next);
  };
  const SceneChange change = drawn_ ? change_between(drawn_->scene, scene) : SceneChange::kView;
  const bool changed = change >= SceneChange::kGeometry;
  if (changed) changed_ = now;
  if (change == SceneChange::kView) view_changed_ = now;
  const double dearer = drawn_ && !asks_same_predicates(drawn_->scene, scene) ? kAnotherSet : 1;
  const auto cost = static_cast<std::size_t>(since_drawn(scene));
  const double whole_s = dearer * cost_s_[cost];
  const bool needed = changed || wants_refinement();
  planned_ = Asked{.scene = scene,
                   .plan = {scene, 1, true, {}},
                   .cost = cost,
                   .since = SceneChange::kView,
                   .sparse = false};
  Plan& plan = planned_->plan;
  const bool in_motion = needed && !is_still(now);
  plan.refined = !in_motion || (whole_s <= options_.budget_s && !interrupted_);
  if (plan.refined) plan.yields_to = SceneChange::kGeometry;
  // However fast the rays are, an image may have to wait while its engine prepares data.
  plan.scene.quality.provisional = in_motion && std::isfinite(options_.budget_s);
  if (!plan.refined) give_up(*planned_, whole_s, dearer, change, now);
  // The cost of a new image cannot be learnt if the engine may have kept parts of the last one.
  planned_->since = since_drawn(with_fewer_pixels(plan.scene, plan.factor));
  return plan;
}

void Refinement::drawn(double took_s, int factor, bool provisional) {
  NAV_CHECK(planned_ && took_s >= 0 && factor >= 1 && factor <= planned_->plan.factor, took_s,
            factor);
  const bool after_coarse = wants_refinement();
  const bool same_set = !drawn_ || asks_same_predicates(drawn_->scene, planned_->scene);
  drawn_ = std::exchange(planned_, std::nullopt);
  drawn_->plan.factor = factor;
  interrupted_ = false;
  if (provisional) drawn_->plan.refined = false;
  // Only the expected cost of a view is known for another predicate set.
  if (!same_set) cost_s_ = {0, 0, 0, kAnotherSet * cost_s_[kOfView]};
  const double whole_s = cost_s_[drawn_->cost];
  const bool anew = drawn_->since == SceneChange::kView;
  if (drawn_->plan.refined) {
    learn_whole(took_s, after_coarse);
  } else if (anew && factor > 1) {
    all_pixels_s_ = took_s * factor * factor;
  } else if (anew && drawn_->sparse && whole_s > 0) {
    sparse_share_ = took_s / whole_s;
  } else if (drawn_->since == SceneChange::kGeometry) {
    learn_kept(took_s * factor * factor);
  }
}

void Refinement::interrupted(double after_s) {
  NAV_CHECK(planned_ && after_s >= 0, after_s);
  const Asked given_up = *std::exchange(planned_, std::nullopt);
  const int factor = given_up.plan.factor;
  // The image would have taken longer than this.
  double& known_s = given_up.plan.refined ? cost_s_[given_up.cost] : all_pixels_s_;
  known_s = std::max(known_s, after_s * factor * factor);
  const double whole_s = cost_s_[given_up.cost];
  if (!given_up.plan.refined && given_up.sparse && whole_s > 0) {
    sparse_share_ = std::max(sparse_share_, after_s / whole_s);
  }
  interrupted_ = true;
  // The engine may have kept nothing of the image before.
  if (given_up.since == SceneChange::kView) drawn_.reset();
}

void Refinement::set_budget(double budget_s) {
  NAV_CHECK(budget_s >= 0, budget_s);
  options_.budget_s = budget_s;
}

/// Objects often rest in every other image. Their images cost next to nothing and must not make the
/// others late, so slow images count at once and fast ones little by little.
void Refinement::learn_kept(double all_pixels_s) {
  constexpr double kOfSlower = 0.7;
  constexpr double kOfFaster = 0.1;
  const double share = all_pixels_s > kept_pixels_s_ ? kOfSlower : kOfFaster;
  kept_pixels_s_ =
      kept_pixels_s_ > 0 ? kept_pixels_s_ + share * (all_pixels_s - kept_pixels_s_) : all_pixels_s;
}

void Refinement::learn_whole(double took_s, bool after_coarse) {
  if (after_coarse) {
    for (double& cost_s : cost_s_) cost_s *= kFading;
    sparse_share_ *= kFading;
  }
  cost_s_[drawn_->cost] = took_s;
}

}  // namespace nav::render
