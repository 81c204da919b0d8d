// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Part of sonde-camera.so only.
#include "devices/camera/camera_part.hpp"

extern "C" __attribute__((visibility("default"))) const void* sonde_camera_part() {
  static const nav::devices::CameraPart part{.make_finder = nav::devices::make_marker_finder,
                                             .open = nav::devices::open_video};
  return &part;
}
