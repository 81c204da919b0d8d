// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// In place of nav_devices_camera in a build without cameras (SONDE_BUILD_CAMERA=OFF).
#include "devices/camera/marker_finder.hpp"
#include "devices/camera/video_input.hpp"

namespace nav::devices {
namespace {

Error no_camera(const std::string& name) {
  return {ErrorCode::kUnavailable,
          name +
              ": this build of Sonde has no cameras: install libopencv-videoio-dev and "
              "libopencv-contrib-dev, and build with SONDE_BUILD_CAMERA=ON"};
}

}  // namespace

Result<std::unique_ptr<MarkerFinder>> make_marker_finder(const MarkerFinderOptions& options) {
  return no_camera(options.camera.string());
}

Result<std::unique_ptr<VideoInput>> open_video(const VideoOptions& options) {
  return no_camera(options.path);
}

}  // namespace nav::devices
