// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "nav/result.hpp"
#include "nav/time.hpp"
#include "nav/transform.hpp"
#include "sim/motion/recorded_hand.hpp"
#include "sim/motion/skin_track.hpp"

namespace nav::sim {

/// Kind of motion by which the hand moves the probe.
enum class HandPathKind {
  kSweep,  ///< Slides perpendicular to the image plane.
  kFan,    ///< Stays at its position and swings the plane about the face's long side.
  kRock,   ///< Stays at its position and swings within the image plane.
  kTilt,   ///< Slides while the plane swings once to and fro.
};

/// Stable lower-case name ("sweep"), and its inverse; kUsage for an unknown name.
const char* to_string(HandPathKind kind);
Result<HandPathKind> hand_path_kind_from(std::string_view name);

/// Involuntary movement of the hand: two bands of sine waves. Drift: postural sway of the arm.
/// Tremor: physiological, 8 to 12 Hz, about 0.1 mm (Elble and Randall 1978; Riviere et al. 2003).
struct HandTremor {
  double drift_mm = 0.8;       ///< Standard deviation along each axis, 0.1 to 1 Hz, [0, 20].
  double drift_rad = 0.008;    ///< Standard deviation about each axis, 0.1 to 1 Hz, [0, 0.2].
  double tremor_mm = 0.08;     ///< Standard deviation along each axis, 8 to 12 Hz, [0, 5].
  double tremor_rad = 0.0008;  ///< Standard deviation about each axis, 8 to 12 Hz, [0, 0.05].
  std::uint64_t seed = 1;
};

struct HandPathOptions {
  HandPathKind kind = HandPathKind::kSweep;
  double length_mm = 60;   ///< Length of the slide (sweep, tilt), [0, 500].
  double angle_rad = 0.9;  ///< Angle from one end of the swing to the other, [0, 3].
  Timestamp begin{};       ///< Start of the motion.
  Timestamp end = Timestamp(std::chrono::seconds(4));  ///< End of the motion, > begin.
  HandTremor tremor;
  /// How uneven the pace is, [0, 0.9]: 0 starts and stops smoothly and is even between; 0.6 goes at
  /// 0.4 to 1.6 times that pace, and slides as much as 4 mm beside the straight way.
  double unevenness = 0;
  /// A hand that was recorded moves in place of the kinds above, at its own pace and with its own
  /// tremor: kind, length_mm, angle_rad, tremor and unevenness do nothing. Null: none.
  std::shared_ptr<const RecordedHand> recorded;
};

/// Rejects invalid options; the message names the first one out of range.
Result<void> validate(const HandPathOptions& options);

/// Involuntary movement of a hand at a time: [turn rad | shift mm] in the moved frame. Closed form.
struct HandWobble {
  Eigen::Vector3d turn_rad;
  Eigen::Vector3d shift_mm;
};
HandWobble wobble_at(const HandTremor& tremor, Timestamp time);

/// Share of the way of an uneven pace after a share of the time, both from 0 to 1: its slope is
/// between 1 - unevenness and 1 + unevenness.
double uneven_share(double share, double unevenness, std::uint64_t seed);

/// Freehand path about a pose that it passes half way. Closed form in time, except for the skin and
/// a recorded hand. A recorded hand keeps its angle to the skin and its place along it, as if it
/// had been recorded on a plane, and stays as deep in the skin as at the middle pose. Thread-safe.
class HandPath {
 public:
  using Pose = Transform<frames::Ct, frames::Image>;
  /// Precondition: validate(options), otherwise a Bug.
  HandPath(const Pose& middle, const HandPathOptions& options);
  /// Path on the skin of a patient, which a slide follows.
  HandPath(const Anatomy& patient, const Pose& middle, const HandPathOptions& options);
  /// Adds a second part: from the end of the path the hand moves to a pose, which it reaches at \p
  /// arrival and holds. Precondition: arrival > options().end, otherwise a Bug.
  void hold(const Pose& pose, Timestamp arrival);
  [[nodiscard]] const HandPathOptions& options() const { return options_; }
  /// The path without the involuntary movement.
  [[nodiscard]] Pose steady(Timestamp time) const;
  [[nodiscard]] Pose at(Timestamp time) const;

 private:
  Pose middle_;
  HandPathOptions options_;
  std::optional<SkinTrack> skin_;  ///< Absent: slides are straight.
  std::vector<Pose> recorded_;     ///< One for each sample of a recorded hand.
  [[nodiscard]] Pose recorded_at(Timestamp time) const;
  struct Held {
    Pose pose;
    Timestamp arrival;
  };
  std::optional<Held> held_;
};

}  // namespace nav::sim
