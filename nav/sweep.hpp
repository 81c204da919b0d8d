// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav {

/// Ultrasound image with its pose at the moment of acquisition.
struct TrackedImage {
  UltrasoundImage frame;
  Transform<frames::Reference, frames::Image> reference_from_image;
  Duration pose_gap;  ///< Time to the nearest measured pose sample, >= 0.
  /// Why the pose is not to be relied on, one sentence; empty when it is.
  std::string doubt{};
  /// Acquisition of the image that this one repeats although the probe has moved, so that its
  /// pixels belong elsewhere; absent: it repeats none.
  std::optional<Timestamp> repeats{};
};

/// Ordered tracked images of one recording, with the calibration that placed them. They are grey:
/// what uses a sweep measures.
class Sweep {
 public:
  /// Rejects an empty list, times that are not strictly increasing, empty images, and images of
  /// different sizes. The message names the image.
  static Result<Sweep> create(std::vector<TrackedImage> frames, std::string calibration_id);

  [[nodiscard]] const std::vector<TrackedImage>& frames() const { return frames_; }
  [[nodiscard]] const std::string& calibration_id() const { return calibration_id_; }
  /// Mean of the image centres, mm, Reference frame; used as the centre of rotation.
  [[nodiscard]] Point<frames::Reference> centroid() const;

 private:
  Sweep(std::vector<TrackedImage> frames, std::string calibration_id)
      : frames_(std::move(frames)), calibration_id_(std::move(calibration_id)) {}
  std::vector<TrackedImage> frames_;
  std::string calibration_id_;
};

}  // namespace nav
