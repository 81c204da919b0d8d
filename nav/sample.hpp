// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "nav/pose.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav {

/// The clock of one device, ns. Its origin and rate are unknown, so its times are a type of their
/// own: nothing compares them with session time before a clock model has mapped them.
struct DeviceClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<DeviceClock>;
  static constexpr bool is_steady = false;
};
using DeviceTime = DeviceClock::time_point;

/// The part that a tracked body plays in a procedure.
enum class ToolRole { kProbe, kReference, kNeedle, kStylus, kPhantom, kOther };
/// Stable name, as in reports: "Probe", "Reference", "Needle", …
const char* to_string(ToolRole role);

/// One pose of a tracked tool, not judged yet.
struct PoseSample {
  RawPose pose;
  /// The tracker's own figure of its error, mm; absent if the tracker gives none.
  std::optional<double> tracker_error_mm = std::nullopt;
};

/// An image that the source could not deliver (0 x 0, invalid status, unsupported type).
struct MissingImage {
  std::string cause;    ///< Stable name for the ledger.
  std::string message;  ///< One sentence.
};

/// Effect of a button, as a session file maps it. Nothing that deletes, accepts a registration or
/// ends a session is among them: a foot may slip.
enum class ButtonAction {
  kNone,     ///< Recorded only.
  kCapture,  ///< Saves what is shown now as an image.
  kFreeze,   ///< Keeps what is shown, or goes on.
  kMark,     ///< Marks this time in the recording and the report.
};
/// Stable name: "none", "capture", "freeze", "mark".
const char* to_string(ButtonAction action);
/// The action of that name; absent: there is none.
std::optional<ButtonAction> button_action_from(std::string_view name);

/// A button of a device that went down or came up.
struct ButtonSample {
  Timestamp acquired{};  ///< Time of the change, session clock.
  bool pressed = false;  ///< Down from then on.
};

/// One sample of one stream.
struct Sample {
  std::size_t stream = 0;      ///< Index in Source::streams().
  std::uint64_t sequence = 0;  ///< Number of the sample in its stream, from the source.
  Timestamp received{};        ///< Time of arrival, session clock.
  /// Stamp of the device on its own clock; absent where the source has already mapped it.
  std::optional<DeviceTime> device_time = std::nullopt;
  std::variant<UltrasoundImage, PoseSample, MissingImage, ButtonSample> what = MissingImage{};
};

}  // namespace nav
