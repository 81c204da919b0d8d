// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "devices/camera/marker_finder.hpp"
#include "devices/camera/video_input.hpp"

namespace nav::devices {

/// Functions of sonde-camera.so, for camera_on_demand.cpp. Both sides are of one build.
struct CameraPart {
  decltype(&make_marker_finder) make_finder;
  decltype(&open_video) open;
};

}  // namespace nav::devices
