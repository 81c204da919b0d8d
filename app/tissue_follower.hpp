// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/json.hpp"
#include "app/navigator.hpp"
#include "app/session/recorded_session.hpp"
#include "nav/volume.hpp"
#include "registration/motion/live_registration.hpp"

namespace nav::app {

/// Keeps the CT with tissue that moves: each new picture refines where the CT lies, from an
/// accepted registration on. A picture that cannot be matched makes the placement stale, a patient
/// who lies no more as when the CT was registered degrades it, and one who is lost takes it away.
/// Not thread-safe.
class TissueFollower {
 public:
  /// Limit of an update that the summary counts against, s: a refresh of 20 Hz.
  static constexpr double kUpdateLimit_s = 0.05;

  /// Prepares the CT about a sweep, whose pictures should have the outline of their sector.
  /// accepted: of a registration that was accepted.
  static Result<TissueFollower> create(const SweepSurvey& sweep, const Volume& ct,
                                       const CtPlacement& accepted, int threads,
                                       Diagnostics& diagnostics);

  /// Where the CT lies for this picture. Pictures that cannot be judged (not later than the last,
  /// impossible geometry) leave it as it was, as stale. Never fails for what a picture shows.
  CtPlacement follow(const TrackedFrame& picture);

  /// What became of all pictures so far: `pictures`, `states`, `alarms`, costs, displacements and
  /// times, for the report.
  [[nodiscard]] Json summary() const;
  /// The same as rows of a table.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> summary_rows() const;
  /// A line of text for every picture: sequence, acquired_ns, state, cost, displacement_mm,
  /// mean_displacement_mm, predicted_rms_mm, distinctness (empty at first), ct_from_reference as tx
  /// ty tz (mm) qx qy qz qw.
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  TissueFollower(registration::LiveRegistration live, const CtPlacement& accepted,
                 Diagnostics& diagnostics);
  void note_state(const registration::LiveUpdate& update, const TrackedFrame& picture);
  void log(const registration::LiveUpdate& update, const TrackedFrame& picture);

  registration::LiveRegistration live_;
  Diagnostics* diagnostics_;
  CtPlacement placement_;
  std::map<std::string, int> states_;
  std::optional<registration::LiveState> last_;
  struct Alarm {
    double session_s;
    std::string state, cause;
  };
  std::vector<Alarm> alarms_;
  std::vector<double> update_s_, costs_;
  double largest_displacement_mm_ = 0;
  std::string text_;
};

}  // namespace nav::app
