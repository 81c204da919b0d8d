// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/marker_source.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nav::devices {

Result<void> validate(const MarkerSourceOptions& options) {
  const auto reject = [](const std::string& what) {
    return Error{ErrorCode::kUsage, "camera markers: expected " + what};
  };
  if (options.streams.empty()) return reject("at least one body, found none");
  for (const MarkerStream& stream : options.streams) {
    if (stream.name.empty()) return reject("a name of each body, found none");
  }
  if (!(options.most_residual_px > 0)) return reject("a largest residual above 0 pixels");
  return validate(options.times);
}

Result<std::unique_ptr<MarkerSource>> MarkerSource::create(MarkerSourceOptions options,
                                                           std::string name, VideoOpener open,
                                                           std::unique_ptr<MarkerFinder> finder,
                                                           const Clock& clock,
                                                           Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<MarkerSource>(new MarkerSource(
      std::move(options), std::move(name), std::move(open), std::move(finder), clock, diagnostics));
}

MarkerSource::MarkerSource(MarkerSourceOptions options, std::string name, VideoOpener open,
                           std::unique_ptr<MarkerFinder> finder, const Clock& clock,
                           Diagnostics& diagnostics)
    : CameraImageSource(std::move(name), options.times, std::move(open), clock, diagnostics,
                        "devices.camera"),
      options_(std::move(options)),
      finder_(std::move(finder)) {
  for (const MarkerStream& stream : options_.streams) {
    add_stream({stream.name, StreamKind::kPoses, stream.role});
  }
}

void MarkerSource::take(VideoImage image, Timestamp acquired, Timestamp received) {
  if (std::ranges::equal(image.pixels.pixels(), before_.pixels())) {
    return count("repeated_image");
  }
  before_ = image.pixels;
  const auto readings = finder_->find(image.pixels);
  if (!readings) {
    count("unusable_image");
    report_once(Severity::kError, readings.error().message);
  }
  for (std::size_t i = 0; i < options_.streams.size(); ++i) {
    PoseSample sample = readings ? pose_of(i, (*readings)[i]) : PoseSample{};
    if (!readings) sample.pose.status = TrackingStatus::kInvalid;
    sample.pose.acquired = acquired;
    sample.pose.received = received;
    deliver({.stream = i, .sequence = sequence_, .received = received, .what = sample});
  }
  ++sequence_;
}

PoseSample MarkerSource::pose_of(std::size_t body, const MarkerReading& reading) {
  PoseSample sample;
  if (reading.points == 0) {
    sample.pose.status = TrackingStatus::kOccluded;
    if (reading.markers > 0) count("no_corners");
    return sample;
  }
  if (!(reading.residual_px <= options_.most_residual_px)) {
    sample.pose.status = TrackingStatus::kInvalid;
    count("bad_fit");
    const std::string& name = options_.streams[body].name;
    report_once(Severity::kWarning, "bad fit " + name,
                name + ": the corners of its markers lie " +
                    std::to_string(std::lround(reading.residual_px)) +
                    " pixels from where they belong; check the sizes of the pattern and the "
                    "calibration of the camera");
    return sample;
  }
  sample.pose.tracker_from_body = reading.camera_from_tool;
  sample.tracker_error_mm = reading.error_mm;
  sample.pose.status = reading.ambiguous ? TrackingStatus::kUnknown : TrackingStatus::kOk;
  if (reading.ambiguous) {
    count("ambiguous");
    const std::string& name = options_.streams[body].name;
    report_once(Severity::kWarning, "ambiguous " + name,
                name +
                    ": its flat pattern may be tilted either way, and its pose is degraded; tilt "
                    "it by 20 degrees, use a larger one, or bring it nearer");
  }
  return sample;
}

}  // namespace nav::devices
