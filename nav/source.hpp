// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav {

/// Ultrasound pictures from a device, a recording or a simulator. A source owns at most one
/// thread and joins it in stop(), which is idempotent.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Next picture in order of arrival; kEndOfStream after the last, kTimeout at the deadline.
  virtual Result<UltrasoundFrame> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

/// Poses of one tracked body, in order of arrival; same rules as FrameSource.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  virtual Result<RawPose> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace nav
