// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// In place of nav_devices_camera: each function loads sonde-camera.so and calls its own there. To
// load OpenCV's cameras takes longer than all the rest of a short command.
#include "devices/camera/camera_part.hpp"
#include "nav/on_demand.hpp"

namespace nav::devices {
namespace {

const Result<const void*>& camera_part() {
  static const Result<const void*> part = functions_on_demand(
      library_of_program("sonde-camera.so", SONDE_PARTS_FOLDER), "sonde_camera_part");
  return part;
}
const CameraPart& functions_of_part() { return *static_cast<const CameraPart*>(*camera_part()); }

}  // namespace

Result<std::unique_ptr<MarkerFinder>> make_marker_finder(const MarkerFinderOptions& options) {
  if (!camera_part()) return camera_part().error();
  return functions_of_part().make_finder(options);
}

Result<std::unique_ptr<VideoInput>> open_video(const VideoOptions& options) {
  if (!camera_part()) return camera_part().error();
  return functions_of_part().open(options);
}

}  // namespace nav::devices
