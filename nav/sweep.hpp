// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav {

/// Ultrasound image with its pose at the moment of acquisition.
struct TrackedFrame {
  UltrasoundFrame frame;
  Transform<frames::Reference, frames::Image> reference_from_image;
  Duration pose_gap;  ///< Time to the nearest measured pose sample, >= 0.
  /// Why the pose is not to be relied on, one sentence; empty when it is.
  std::string doubt{};
};

/// Ordered tracked images of one recording, with the calibration that placed them.
class Sweep {
 public:
  /// Rejects an empty list, times that are not strictly increasing, empty images, and images of
  /// different sizes. The message names the image.
  static Result<Sweep> create(std::vector<TrackedFrame> frames, std::string calibration_id);

  [[nodiscard]] const std::vector<TrackedFrame>& frames() const { return frames_; }
  [[nodiscard]] const std::string& calibration_id() const { return calibration_id_; }
  /// Mean of the image centres, mm, Reference frame; used as the centre of rotation.
  [[nodiscard]] Point<frames::Reference> centroid() const;

 private:
  Sweep(std::vector<TrackedFrame> frames, std::string calibration_id)
      : frames_(std::move(frames)), calibration_id_(std::move(calibration_id)) {}
  std::vector<TrackedFrame> frames_;
  std::string calibration_id_;
};

}  // namespace nav
