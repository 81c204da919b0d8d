// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_cameras.hpp"

#include <utility>

#include "devices/camera/frame_grabber_source.hpp"
#include "devices/camera/marker_source.hpp"
#include "session/device_address.hpp"

namespace nav::session {
namespace {

constexpr const char* kMarkersKind = "camera-markers";
constexpr const char* kGrabberKind = "frame-grabber";
constexpr int kMostCameraSide = 16384;
constexpr double kMostImagesHz = 1000;

std::vector<devices::MarkerTool> tools_of(const DeviceOptions& device) {
  std::vector<devices::MarkerTool> tools;
  for (const DeviceBody& body : device.bodies) {
    if (auto tool = devices::marker_tool(body.tool)) tools.push_back(*tool);
  }
  return tools;
}

devices::VideoOpener opener_of(const DeviceOptions& device) {
  const CameraAddress address = *camera_address(device.address);
  return [options = devices::VideoOptions{.path = address.path,
                                          .is_device = address.is_device,
                                          .width = device.width,
                                          .height = device.height,
                                          .rate_hz = device.images_hz,
                                          .colours = device.kind == kGrabberKind}] {
    return devices::open_video(options);
  };
}

Result<LiveDevice> open_grabber(const DeviceOptions& device, const Clock& clock,
                                Diagnostics& diagnostics) {
  devices::FrameGrabberOptions options{.image = device.image};
  if (const auto crop = screen_area(device.crop)) {
    options.crop = {crop->left, crop->top, crop->width, crop->height};
  }
  auto opened =
      devices::FrameGrabberSource::create(std::move(options), camera_address(device.address)->path,
                                          opener_of(device), clock, diagnostics);
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

}  // namespace

bool is_camera(const DeviceOptions& device) {
  return device.kind == kMarkersKind || device.kind == kGrabberKind;
}

std::optional<ImageWatchOptions> screen_watch_of(const DeviceOptions& device) {
  if (device.kind != kGrabberKind) return std::nullopt;
  return ImageWatchOptions{.depth_display = screen_area(device.depth_display)};
}

Result<void> validate_camera(const DeviceOptions& device, const std::string& name) {
  const auto reject = [&](const std::string& key, const std::string& expected,
                          const std::string& found) {
    return Error{ErrorCode::kUsage,
                 name + "." + key + ": expected " + expected + ", found '" + found + "'"};
  };
  if (!camera_address(device.address)) {
    return reject("address", "v4l2:/dev/video… or film:FILE", device.address);
  }
  for (const auto& [key, side] : {std::pair{"width", device.width}, {"height", device.height}}) {
    if (side >= 0 && side <= kMostCameraSide) continue;
    return reject(key, "0 to " + std::to_string(kMostCameraSide) + " pixels", std::to_string(side));
  }
  if (!(device.images_hz >= 0 && device.images_hz <= kMostImagesHz)) {
    return reject("images_hz", "0 to 1000 Hz", std::to_string(device.images_hz));
  }
  if (device.kind == kGrabberKind) {
    if (device.image.empty()) return reject("image", "a name of the images", "");
    for (const auto& [key, numbers] :
         {std::pair{"crop", &device.crop}, {"depth_display", &device.depth_display}}) {
      if (numbers->empty() || screen_area(*numbers)) continue;
      return reject(key, "[left, top, width, height] in whole pixels", "other numbers");
    }
    return {};
  }
  if (device.camera.empty()) return reject("camera", "the file of the camera's calibration", "");
  if (device.bodies.empty()) return reject("bodies", "at least one body", "none");
  for (std::size_t i = 0; i < device.bodies.size(); ++i) {
    if (devices::marker_tool(device.bodies[i].tool)) continue;
    return reject("bodies[" + std::to_string(i) + "].tool", devices::kMarkerToolForms,
                  device.bodies[i].tool);
  }
  if (auto ok = devices::validate(tools_of(device), device.dictionary); !ok) {
    return Error{ErrorCode::kUsage, name + "." + ok.error().message};
  }
  return {};
}

Result<LiveDevice> open_camera(const DeviceOptions& device, const std::string& needle_body,
                               const SourceOptions& source, const Clock& clock,
                               Diagnostics& diagnostics) {
  if (device.kind == kGrabberKind) return open_grabber(device, clock, diagnostics);
  auto finder = devices::make_marker_finder(
      {.tools = tools_of(device), .dictionary = device.dictionary, .camera = device.camera});
  if (!finder) return finder.error();
  devices::MarkerSourceOptions options;
  for (const DeviceBody& body : device.bodies) {
    const ToolRole role = body.name == needle_body ? ToolRole::kNeedle : role_of(body.name, source);
    options.streams.push_back({body.name, role});
  }
  auto opened =
      devices::MarkerSource::create(std::move(options), camera_address(device.address)->path,
                                    opener_of(device), *std::move(finder), clock, diagnostics);
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

}  // namespace nav::session
