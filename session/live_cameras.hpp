// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "session/image_watch.hpp"
#include "session/live_devices.hpp"

namespace nav::session {

/// True for the kinds "camera-markers" and "frame-grabber".
bool is_camera(const DeviceOptions& device);

/// Watch over the images of a frame grabber; absent: the device says how its images lie.
std::optional<ImageWatchOptions> screen_watch_of(const DeviceOptions& device);

/// Rejects an address, a pattern, a dictionary or an area that the kind cannot have. \p name: of
/// the device in messages, "devices[0]".
Result<void> validate_camera(const DeviceOptions& device, const std::string& name);

/// Opens a camera; needle_body and source as open_device(). Precondition: validate_camera().
/// Errors: those of devices::make_marker_finder().
Result<LiveDevice> open_camera(const DeviceOptions& device, const std::string& needle_body,
                               const SourceOptions& source, const Clock& clock,
                               Diagnostics& diagnostics);

}  // namespace nav::session
