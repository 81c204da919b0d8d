// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "nav/pose.hpp"
#include "nav/ultrasound_frame.hpp"

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

/// One sample of one stream.
struct Sample {
  std::size_t stream = 0;      ///< Index in Source::streams().
  std::uint64_t sequence = 0;  ///< Number of the sample in its stream, from the source.
  Timestamp received{};        ///< Time of arrival, session clock.
  /// Stamp of the device on its own clock; absent where the source has already mapped it.
  std::optional<DeviceTime> device_time = std::nullopt;
  std::variant<UltrasoundFrame, PoseSample, MissingImage> what = MissingImage{};
};

}  // namespace nav
