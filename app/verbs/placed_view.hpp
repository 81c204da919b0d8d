// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/views/presenter.hpp"
#include "session/placement.hpp"
#include "session/recorded_session.hpp"
#include "session/tissue_follower.hpp"

namespace nav::app {

/// The CT of a session in its place, and the view of it. The first tracked image decides what
/// depends on where the images lie; later ones move a CT that follows the tissue. Not thread-safe.
class PlacedView {
 public:
  struct Parts {
    std::shared_ptr<const Volume> ct;
    /// Placement that the options give; none: the first image decides.
    std::optional<session::Placement> given;
    /// The whole sweep, for camera and grey window; none: the first image decides.
    std::optional<session::SweepSurvey> survey;
    Presenter presenter;
    bool needle_expected = false;  ///< A needle is tracked; its state is always shown.
    std::string banner;            ///< Kind of the session, which every image shows.
    /// 3D ultrasound that the presenter draws by predicates; null: none.
    std::shared_ptr<const PredicateSource> predicates{};
  };
  /// Reads the CT and what is drawn with it, and makes the presenter. \p reference_frame: the
  /// patient's frame, to which a registration has to belong.
  static Result<Parts> prepare(const SessionConfig& config, const std::string& reference_frame,
                               Console& console);
  /// Does the same with a CT that is there already.
  static Result<Parts> prepare(const SessionConfig& config, const std::string& reference_frame,
                               std::shared_ptr<const Volume> ct, Console& console);
  /// Shows 3D ultrasound alone, without a CT: slices show the volume itself.
  static Result<Parts> prepare_alone(const SessionConfig& config, PreparedPredicates prepared);

  /// Configuration and console must outlive the view.
  PlacedView(const SessionConfig& config, Console& console, Parts parts);

  /// Prepares the view of the CT alone, for a session that is looked at before its first image.
  /// Returns the placement that the options give; absent: the first image decides.
  std::optional<session::CtPlacement> show_before_images();
  /// Takes a tracked image, in order. \p read: what is known of the recording. Returns the
  /// placement that the session has to take over, if it changed.
  Result<std::optional<session::CtPlacement>> take(
      const TrackedImage& image, const std::optional<session::RecordingRead>& read);
  /// Replaces the plan of the session.
  void set_plan(const std::optional<NeedlePlan>& plan);
  /// Replaces the placement of the CT, as the user has moved it.
  void set_placement(session::Placement placement);
  /// Reports, once, where nothing of the ultrasound volume is to be seen, and where a cutaway takes
  /// away some of what is most important in it.
  Result<void> check_ultrasound(const session::Epoch& epoch);
  /// Reports, once, where the volume in front of the first live plane hides it, and what helps.
  Result<void> check_plane(const session::Epoch& epoch);
  /// Reports the engine's note about the last image, once.
  void say_note();

  [[nodiscard]] Presenter& presenter() { return presenter_; }
  [[nodiscard]] std::string engine_name() { return presenter_.engine().name(); }
  [[nodiscard]] const Volume& ct() const { return *ct_; }
  [[nodiscard]] const std::shared_ptr<const Volume>& shared_ct() const { return ct_; }
  [[nodiscard]] const std::optional<NeedlePlan>& plan() const { return plan_; }
  /// 3D ultrasound that is drawn by predicates; null: none.
  [[nodiscard]] const std::shared_ptr<const PredicateSource>& predicates() const {
    return predicates_;
  }
  [[nodiscard]] bool needle_expected() const { return needle_expected_; }
  [[nodiscard]] const std::optional<session::SweepSurvey>& survey() const { return survey_; }
  /// Absent before the first tracked image.
  [[nodiscard]] const std::optional<session::Placement>& placement() const { return placement_; }
  /// Absent unless the CT follows the tissue.
  [[nodiscard]] const std::optional<session::TissueFollower>& follower() const { return follower_; }
  /// One sentence while no image has met the CT; else empty.
  [[nodiscard]] std::string outside() const { return outside_.warning(); }

 private:
  Result<session::CtPlacement> begin(const TrackedImage& image,
                                     const std::optional<session::RecordingRead>& read);
  /// Replaces the warning that every image shows; empty: none.
  void warn(std::string warning);
  Result<void> check_importance(const render::Scene& scene);

  const SessionConfig& config_;
  Console& console_;
  std::shared_ptr<const Volume> ct_;
  std::optional<session::Placement> given_;
  std::optional<session::SweepSurvey> survey_;
  Presenter presenter_;
  std::optional<NeedlePlan> plan_;
  bool needle_expected_;
  std::string banner_;
  std::shared_ptr<const PredicateSource> predicates_;
  std::optional<session::Placement> placement_;
  session::OutsideWatch outside_;
  std::optional<session::TissueFollower> follower_;
  bool plane_checked_ = false;
  bool ultrasound_checked_ = false;
  std::string note_;  ///< The engine's note that was reported.
};

}  // namespace nav::app
