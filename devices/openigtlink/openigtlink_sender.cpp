// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/openigtlink_sender.hpp"

#include <algorithm>
#include <limits>

#include "devices/openigtlink/igtl_bytes.hpp"
#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_poses.hpp"
#include "devices/openigtlink/openigtlink_source.hpp"

namespace nav::devices {

void OpenIgtLinkSender::send(const StreamInfo& stream, const Sample& sample) const {
  const auto stamp_of = [&](Timestamp acquired) {
    return igtl_stamp(sample.device_time ? *sample.device_time
                                         : session_began_ + acquired.time_since_epoch());
  };
  if (const auto* pose = std::get_if<PoseSample>(&sample.what)) {
    send_pose(plus_transform_name(stream.name, tracker_frame_), pose->pose,
              stamp_of(pose->pose.acquired));
  } else if (const auto* image = std::get_if<UltrasoundImage>(&sample.what)) {
    send_image(stream.name, *image, stamp_of(image->acquired));
  }
}

void OpenIgtLinkSender::send_pose(const std::string& name, const RawPose& pose,
                                  std::uint64_t stamp) const {
  const bool finite = pose.tracker_from_body.allFinite();
  const bool claims = pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown;
  const TrackingStatus status = claims && !finite ? TrackingStatus::kInvalid : pose.status;
  std::vector<std::byte> content;
  IgtlWriter writer(content);
  IgtlTransform::from(finite ? pose.tracker_from_body : Eigen::Matrix4d::Identity()).write(writer);
  const IgtlMetadataEntry entry{.key = "TransformStatus", .value = igtl_status_text(status)};
  IgtlEnvelope envelope{.version = 2, .type = "TRANSFORM", .device = name, .stamp = stamp};
  if (status != TrackingStatus::kUnknown) envelope.metadata = std::span(&entry, 1);
  server_.send(envelope, content);
}

void OpenIgtLinkSender::send_image(const std::string& name, const UltrasoundImage& image,
                                   std::uint64_t stamp) const {
  constexpr int kMost = std::numeric_limits<std::uint16_t>::max();
  if (image.pixels.empty() || std::max(image.pixels.width(), image.pixels.height()) > kMost) return;
  IgtlImage out;
  out.size = out.part_size = {static_cast<std::uint16_t>(image.pixels.width()),
                              static_cast<std::uint16_t>(image.pixels.height()), 1};
  const auto column = static_cast<float>(image.grid.mm_per_pixel.col(0).norm());
  const auto row = static_cast<float>(image.grid.mm_per_pixel.col(1).norm());
  out.steps_mm = {{{column, 0, 0}, {0, row, 0}, {0, 0, 1}}};
  if (image.colours.empty()) {
    out.pixels = std::as_bytes(image.pixels.pixels());
  } else {
    out.components = 3;
    out.pixels = std::as_bytes(image.colours.pixels());
  }
  std::vector<std::byte> content;
  append_igtl_image(content, out);
  server_.send({.version = 2, .type = "IMAGE", .device = name, .stamp = stamp}, content);
}

}  // namespace nav::devices
