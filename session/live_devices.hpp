// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/probe_calibration.hpp"
#include "nav/source.hpp"
#include "session/options.hpp"

namespace nav::session {

/// A device that a session has opened.
struct LiveDevice {
  DeviceOptions options;
  std::shared_ptr<Source> source;
  /// Position of the images on the probe, if the device knows it: a recording or a simulation.
  std::optional<ProbeCalibration> calibration = std::nullopt;
  /// Tip of the needle relative to the body that the device tracks, if it knows it, mm.
  std::optional<Eigen::Matrix4d> body_from_tip = std::nullopt;
  /// False where a stream for the reference stands in the list, but never delivers.
  bool tracks_patient = true;
};

/// The part that a body plays, by the names of the session's coordinate frames.
ToolRole role_of(const std::string& body, const SourceOptions& source);

/// Kinds of devices, as in a session file.
const std::vector<std::string>& device_kinds();

/// Kind of a live session by its devices: one with a simulated or recorded device is not taken for
/// one of a patient.
enum class LiveKind { kLive, kRecording, kSimulated };
LiveKind live_kind(const std::vector<DeviceOptions>& devices);

/// Rejects an unknown kind, an address that the kind cannot read, no streams, and keys out of
/// range, by name: "devices[0].address: expected …, found …".
Result<void> validate(const std::vector<DeviceOptions>& devices);

/// Opens a device; what it opens begins to deliver with the first next(). \p needle_body: name of
/// the body that is the needle; may be empty. \p source names the other coordinate frames. Clock
/// and diagnostics must outlive it. Errors begin with the device's id.
Result<LiveDevice> open_device(const DeviceOptions& device, const std::string& needle_body,
                               const SourceOptions& source, const Clock& clock,
                               Diagnostics& diagnostics);

}  // namespace nav::session
