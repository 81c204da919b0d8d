// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav {

/// Source of ultrasound images: a device, a recording or a simulator. It owns at most one thread,
/// which stop() joins. stop() is idempotent.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Returns the next image in order of arrival; kEndOfStream after the last one, kTimeout at the
  /// deadline.
  virtual Result<UltrasoundFrame> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

/// Source of the poses of one tracked body, in order of arrival. The rules of FrameSource apply.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  virtual Result<RawPose> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace nav
