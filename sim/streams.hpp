// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav::sim {

/// Images of a simulation in order of arrival, on the virtual clock.
class ImageStream {
 public:
  virtual ~ImageStream() = default;
  /// Next image that has arrived by the deadline; otherwise kTimeout. kEndOfStream after the last.
  virtual Result<UltrasoundImage> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

/// Poses of one tracked body, with the same rules as ImageStream.
class PoseStream {
 public:
  virtual ~PoseStream() = default;
  virtual Result<RawPose> next(Deadline deadline) = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace nav::sim
