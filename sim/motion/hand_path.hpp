// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "nav/result.hpp"
#include "nav/time.hpp"
#include "nav/transform.hpp"
#include "sim/motion/skin_track.hpp"

namespace nav::sim {

/// How the hand leads the probe.
enum class HandPathKind {
  kSweep,  ///< Slides across the picture's plane.
  kFan,    ///< Stays in place and swings the plane about the face's long side.
  kRock,   ///< Stays in place and swings within the picture's plane.
  kTilt,   ///< Slides while the plane swings once to and fro.
};

/// Stable lower-case name ("sweep"), and back; kUsage for a name that is none.
const char* to_string(HandPathKind kind);
Result<HandPathKind> hand_path_kind_from(std::string_view name);

/// Movement of a hand that is not perfectly steady: two bands of sine waves. Drift: postural sway
/// of the arm. Tremor: physiological, 8 to 12 Hz, about 0.1 mm (Elble and Randall 1978; Riviere
/// et al. 2003).
struct HandTremor {
  double drift_mm = 0.8;       ///< Standard deviation along each axis, 0.1 to 1 Hz, [0, 20].
  double drift_rad = 0.008;    ///< The same about each axis, [0, 0.2].
  double tremor_mm = 0.08;     ///< 8 to 12 Hz, [0, 5].
  double tremor_rad = 0.0008;  ///< [0, 0.05].
  std::uint64_t seed = 1;
};

struct HandPathOptions {
  HandPathKind kind = HandPathKind::kSweep;
  double length_mm = 60;   ///< Of the slide (sweep, tilt), [0, 500].
  double angle_rad = 0.9;  ///< From one end of the swing to the other, [0, 3].
  Timestamp begin{};       ///< The probe stands still before it
  Timestamp end = Timestamp(std::chrono::seconds(4));  ///< and after it. end > begin.
  HandTremor tremor;
};

/// A refusal that names the first option out of range.
Result<void> validate(const HandPathOptions& options);

/// The wobble of a hand at a time: [turn rad | shift mm] in the moved frame. Closed form.
struct HandWobble {
  Eigen::Vector3d turn_rad;
  Eigen::Vector3d shift_mm;
};
HandWobble wobble_at(const HandTremor& tremor, Timestamp time);

/// A freehand path about a pose that it passes half way. Closed form in time, but for the skin;
/// thread-safe.
class HandPath {
 public:
  using Pose = Transform<frames::Ct, frames::Image>;
  /// Precondition: validate(options), otherwise a Bug.
  HandPath(const Pose& middle, const HandPathOptions& options);
  /// The same on the skin of a patient, which a slide follows.
  HandPath(const Anatomy& patient, const Pose& middle, const HandPathOptions& options);
  [[nodiscard]] const HandPathOptions& options() const { return options_; }
  /// The path without the hand's wobble.
  [[nodiscard]] Pose steady(Timestamp time) const;
  [[nodiscard]] Pose at(Timestamp time) const;

 private:
  Pose middle_;
  HandPathOptions options_;
  std::optional<SkinTrack> skin_;  ///< Absent: slides are straight.
};

}  // namespace nav::sim
