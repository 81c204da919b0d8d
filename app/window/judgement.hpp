// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/window/moment.hpp"
#include "app/window/view_id.hpp"

namespace nav::app {

/// Judgement of one view.
struct ViewJudgement {
  Safety safety;           ///< State of what it shows.
  std::string about{};     ///< The part that has the state, if not the whole view: "plane".
  bool covered = false;    ///< Its image must not be taken for the present.
  std::string headline{};  ///< Covered: "ULTRASOUND STALE".
  bool late = false;       ///< It shows an older moment than another view.
  double age_ms = 0;       ///< Age of the moment it shows.
};

/// Judgement of the whole window at a time.
struct Judgement {
  ViewJudgement ultrasound, ct, scene;
  ViewJudgement slices;    ///< The three slices along the patient's axes.
  ViewJudgement needle;    ///< The two slices along the needle.
  ViewJudgement bullseye;  ///< Shown while there are numbers.
  /// Numbers of the needle; absent: withdrawn, for the cause.
  std::optional<NeedleGuidance> guidance;
  std::optional<session::GuidanceError> error{};  ///< Intervals of these numbers.
  /// Distance from the nearest critical structure in the moment of the numbers; absent without
  /// them.
  std::optional<session::NearestStructure> nearest{};
  std::string withdrawn{};
};

/// The part of a judgement that is about a view.
const ViewJudgement& judgement_of(const Judgement& judgement, ViewId id);
ViewJudgement& judgement_of(Judgement& judgement, ViewId id);

/// Time that drawing and waiting for each other may add to the validity of an image.
inline constexpr Duration kDrawingAllowance = std::chrono::milliseconds(150);

/// A 3D view that shows an older moment than the others for longer than this is covered, even if
/// nothing in it is live.
inline constexpr Duration kLongestLate = std::chrono::seconds(2);

/// Sentences of engines that failed; empty: they did not.
struct EngineFailures {
  std::string scene{}, flat{};
};

/// Judges the views and numbers that are on the screen now. The watchdog of the window: it depends
/// on no other thread, so it holds when an engine or the session hangs.
///
/// \p newest: newest moment of the session; \p flat, \p scene: moments that the flat views and the
/// 3D view show; each may be null.
///
/// \p structures: number of the newest change of plan and critical structures. Distances that were
/// made for older ones are withdrawn.
///
/// The CT of the slices does not age; the line of the live plane and the needle in them do.
Judgement judge(const SharedMoment& newest, const SharedMoment& flat, const SharedMoment& scene,
                const EngineFailures& failures, Timestamp now, std::uint64_t structures = 0);

}  // namespace nav::app
