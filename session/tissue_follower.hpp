// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "registration/motion/live_registration.hpp"
#include "session/navigator.hpp"
#include "session/recorded_session.hpp"

namespace nav::session {

/// Keeps the CT with tissue that moves: each new image refines the position of the CT, from an
/// accepted registration on. An image that cannot be matched makes the placement stale, a patient
/// who has moved since the CT was registered degrades it, and one who is lost takes it away.
/// Not thread-safe.
class TissueFollower {
 public:
  /// Limit of an update that the summary counts against, s: a refresh of 20 Hz.
  static constexpr double kUpdateLimit_s = 0.05;

  /// Prepares the CT around the first image; later images extend that part when they leave it.
  /// Images of convex probes should have the outline of their sector. \p accepted: placement of a
  /// registration that was accepted. Precondition: ct.
  static Result<TissueFollower> create(std::shared_ptr<const Volume> ct,
                                       const CtPlacement& accepted, const TrackedImage& first,
                                       int threads, Diagnostics& diagnostics);

  /// Position of the CT for this image. Images that cannot be judged (not later than the last,
  /// impossible geometry) leave it unchanged, as stale. Never fails because of an image's content.
  CtPlacement follow(const TrackedImage& image);

  /// A change to a state that the user must act on.
  struct Alarm {
    double session_s;
    std::string state, cause;
  };
  /// Outcome of all images so far, for the report.
  struct Summary {
    std::size_t images = 0;
    std::map<std::string, int> states;  ///< Images by state.
    std::vector<Alarm> alarms;
    double largest_displacement_mm = 0;  ///< From the accepted registration.
    double cost_median = 0;              ///< NaN before the first image.
    double update_s_median = 0;          ///< Wall time of an update, s; NaN before the first.
    std::ptrdiff_t updates_over_limit = 0;
  };
  [[nodiscard]] Summary summary() const;
  /// A line of text for every image: sequence, acquired_ns, state, cost, displacement_mm,
  /// mean_displacement_mm, predicted_rms_mm, distinctness (empty at first), ct_from_reference as tx
  /// ty tz (mm) qx qy qz qw.
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  TissueFollower(registration::LiveRegistration live, std::shared_ptr<const Volume> ct,
                 const registration::CtBox& box, const CtPlacement& accepted,
                 Diagnostics& diagnostics);
  Result<void> extend_to(const TrackedImage& image);
  void note_state(const registration::LiveUpdate& update, const TrackedImage& image);
  void log(const registration::LiveUpdate& update, const TrackedImage& image);

  registration::LiveRegistration live_;
  std::shared_ptr<const Volume> ct_;
  registration::CtBox box_;  ///< Part of the CT that is prepared.
  Diagnostics* diagnostics_;
  CtPlacement placement_;
  std::map<std::string, int> states_;
  std::optional<registration::LiveState> last_;
  std::vector<Alarm> alarms_;
  std::vector<double> update_s_, costs_;
  double largest_displacement_mm_ = 0;
  std::string text_;
};

}  // namespace nav::session
