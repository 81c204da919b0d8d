// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "devices/openigtlink/openigtlink_server.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Sends samples by a server, named and marked as PLUS does:
///   - a pose of a body "Probe" as TRANSFORM "ProbeToTracker" with its status as TransformStatus. A
///     pose that is not finite is sent as the identity, with its status, which is then never OK;
///   - an image as IMAGE with its pixel spacing, RGB if it has colours.
/// Thread-safe if each stream is sent by one thread.
class OpenIgtLinkSender {
 public:
  /// \p tracker_frame: name of the frame to which poses lead. \p session_began: time of the wall
  /// clock at session time 0. The server must outlive the sender.
  OpenIgtLinkSender(OpenIgtLinkServer& server, std::string tracker_frame, DeviceTime session_began)
      : server_(server), tracker_frame_(std::move(tracker_frame)), session_began_(session_began) {}

  /// Samples without data (MissingImage) are not sent.
  void send(const StreamInfo& stream, const Sample& sample) const;

 private:
  void send_pose(const std::string& name, const RawPose& pose, std::uint64_t stamp) const;
  void send_image(const std::string& name, const UltrasoundImage& image, std::uint64_t stamp) const;

  OpenIgtLinkServer& server_;
  std::string tracker_frame_;
  DeviceTime session_began_;
};

}  // namespace nav::devices
