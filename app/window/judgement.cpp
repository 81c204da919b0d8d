// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/judgement.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace nav::app {
namespace {

std::string upper(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return word;
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

/// Stale when a time has passed, whatever the session's thread says.
Safety watched(const Safety& safety, const std::string& what, std::optional<Timestamp> until,
               std::optional<Timestamp> since, Timestamp now) {
  if (!until || now <= *until + kDrawingAllowance) return safety;
  const double age = to_seconds(now - since.value_or(*until));
  return compose({safety, {SafetyState::kStale, "no new " + what + " for " + seconds_text(age)}});
}

ViewJudgement judged(const std::string& name, Safety safety, const Moment& shown, Timestamp now) {
  ViewJudgement view;
  view.covered = safety.state >= SafetyState::kStale;
  if (view.covered) view.headline = name + " " + upper(to_string(safety.state));
  view.safety = std::move(safety);
  view.age_ms = 1e3 * to_seconds(now - shown.published);
  return view;
}

ViewJudgement nothing_yet(const std::string& name) {
  return {.safety = {SafetyState::kLost, "nothing received yet"},
          .covered = true,
          .headline = name + " LOST"};
}

/// The 3D view and the slices show the CT, which does not age; live parts of it do.
/// others: number of the moment that other views show; 0: none.
ViewJudgement judge_ct_view(const std::string& name, const Moment& newest, std::uint64_t others,
                            const Moment& shown, const std::string& engine_failure, Timestamp now) {
  ViewJudgement view;
  view.safety = newest.epoch.plane;
  view.late = others > shown.number;
  view.age_ms = 1e3 * to_seconds(now - shown.published);
  const session::Epoch& epoch = shown.epoch;
  std::vector<Timestamp> ends;
  if (epoch.plane.state <= SafetyState::kDegraded && shown.ultrasound_until) {
    ends.push_back(*shown.ultrasound_until);
  }
  if (epoch.ct_from_needle && epoch.needle.state <= SafetyState::kDegraded && shown.needle_until) {
    ends.push_back(*shown.needle_until);
  }
  const bool too_old = std::any_of(
      ends.begin(), ends.end(), [&](Timestamp until) { return now > until + kDrawingAllowance; });
  const bool stands_still = view.late && now - shown.published > kLongestLate;
  if (!engine_failure.empty()) {
    view.covered = true;
    view.headline = name + " LOST";
    view.safety = {SafetyState::kLost, engine_failure};
  } else if (too_old || stands_still) {
    view.covered = true;
    view.headline = name + " STALE";
    view.safety = {SafetyState::kStale,
                   "no new image of this view for " + seconds_text(view.age_ms / 1e3)};
  } else if (newest.stored) {
    view.about = "volume";
    view.safety = {SafetyState::kValid, ""};
  } else {
    view.about = "plane";
  }
  return view;
}

/// A bull's-eye is read as a number, and withdrawn with the numbers.
ViewJudgement judge_bulls_eye(const Judgement& judgement) {
  ViewJudgement view = judgement.needle;
  if (judgement.guidance || view.safety.state == SafetyState::kLost) return view;
  view.covered = true;
  view.headline = "BULL'S-EYE WITHDRAWN";
  if (view.safety.state == SafetyState::kValid) view.safety.state = SafetyState::kLost;
  view.safety.cause = judgement.withdrawn;
  return view;
}

std::uint64_t number_of(const SharedMoment& moment) { return moment ? moment->number : 0; }

}  // namespace

Judgement judge(const SharedMoment& newest, const SharedMoment& flat, const SharedMoment& scene,
                const EngineFailures& failures, Timestamp now, std::uint64_t structures) {
  Judgement judgement{.ultrasound = nothing_yet("ULTRASOUND"),
                      .ct = nothing_yet("CT PLANE"),
                      .scene = nothing_yet("3D VIEW"),
                      .slices = nothing_yet("SLICE"),
                      .needle = nothing_yet("NEEDLE"),
                      .bullseye = nothing_yet("BULL'S-EYE"),
                      .guidance = std::nullopt,
                      .withdrawn = "no session yet"};
  if (!newest) return judgement;
  if (flat) {
    // The older of both decides: what is on the screen, and what the session last said.
    const auto image = [&](const Safety& safety) {
      return watched(safety, "ultrasound image", flat->ultrasound_until, flat->acquired, now);
    };
    judgement.ultrasound =
        judged("ULTRASOUND", image(compose({newest->epoch.ultrasound, flat->epoch.ultrasound})),
               *flat, now);
    judgement.ct =
        judged("CT PLANE", image(compose({newest->epoch.plane, flat->epoch.plane})), *flat, now);
    const auto needle = watched(compose({newest->epoch.needle, flat->epoch.needle}), "needle pose",
                                flat->needle_until, flat->published, now);
    judgement.needle = judged("NEEDLE", compose({needle, newest->epoch.placement}), *flat, now);
    if (newest->stored) {
      const Safety none{SafetyState::kLost, newest->predicates
                                                ? "a stored volume is shown: there is no live image"
                                                : newest->epoch.ultrasound.cause};
      judgement.ultrasound = judged("ULTRASOUND", none, *flat, now);
      judgement.ct = judged("CT PLANE", none, *flat, now);
    }
    judgement.slices = judge_ct_view("SLICE", *newest, number_of(scene), *flat, failures.flat, now);
    // Until the image without the line of the plane comes.
    const bool has_line = flat->epoch.plane.state <= SafetyState::kDegraded;
    if (has_line && newest->epoch.plane.state >= SafetyState::kStale) {
      judgement.slices.covered = true;
      judgement.slices.headline = "SLICE " + upper(to_string(newest->epoch.plane.state));
      judgement.slices.about.clear();
    }
    const bool late = scene && scene->number > flat->number;
    for (ViewJudgement* view : {&judgement.ultrasound, &judgement.ct, &judgement.needle}) {
      view->late = late;
      if (failures.flat.empty()) continue;
      view->covered = true;
      view->headline = "VIEW LOST";
      view->safety = {SafetyState::kLost, failures.flat};
    }
  }
  if (scene) {
    judgement.scene =
        judge_ct_view("3D VIEW", *newest, number_of(flat), *scene, failures.scene, now);
  } else if (!failures.scene.empty()) {
    judgement.scene.safety.cause = failures.scene;
  }
  const Safety needle =
      watched(newest->epoch.needle, "needle pose", newest->needle_until, newest->published, now);
  const SharedMoment& numbers = flat ? flat : newest;
  const Safety shown =
      watched(numbers->epoch.needle, "needle pose", numbers->needle_until, numbers->published, now);
  if (newest->epoch.guidance && numbers->epoch.guidance && needle.shows_numbers() &&
      shown.shows_numbers()) {
    judgement.guidance = numbers->epoch.guidance;
    judgement.error = numbers->guidance_error;
    judgement.nearest = numbers->nearest;
    if (numbers->structures != structures || !judgement.nearest) {
      judgement.nearest = {.state = session::NearestStructure::State::kPending};
    }
    judgement.withdrawn.clear();
  } else {
    const Safety worst = compose({needle, shown});
    judgement.withdrawn = !worst.cause.empty() ? worst.cause
                          : !newest->plan      ? "no plan: no target"
                                               : newest->epoch.plane.cause;
  }
  if (flat) judgement.bullseye = judge_bulls_eye(judgement);
  return judgement;
}

ViewJudgement& judgement_of(Judgement& judgement, ViewId id) {
  switch (id) {
    case ViewId::kScene:
      return judgement.scene;
    case ViewId::kUltrasound:
      return judgement.ultrasound;
    case ViewId::kCt:
      return judgement.ct;
    case ViewId::kNeedleFirst:
    case ViewId::kNeedleSecond:
      return judgement.needle;
    case ViewId::kBullsEye:
      return judgement.bullseye;
    default:
      return judgement.slices;
  }
}

const ViewJudgement& judgement_of(const Judgement& judgement, ViewId id) {
  return judgement_of(const_cast<Judgement&>(judgement), id);  // NOLINT
}

}  // namespace nav::app
