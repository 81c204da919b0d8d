// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav {

/// A picture with its pose at the moment of acquisition.
struct TrackedFrame {
  UltrasoundFrame frame;
  Transform<frames::Reference, frames::Image> reference_from_image;
  Duration pose_gap;      ///< Distance in time to the nearest real pose sample, >= 0.
  bool degraded = false;  ///< A contributing pose came without a status.
};

/// Ordered tracked frames of one recording with the calibration that placed them.
class Sweep {
 public:
  /// Refuses: no frames, times not strictly increasing, empty pictures, pictures of different
  /// size. The message names the frame.
  static Result<Sweep> create(std::vector<TrackedFrame> frames, std::string calibration_id);

  [[nodiscard]] const std::vector<TrackedFrame>& frames() const { return frames_; }
  [[nodiscard]] const std::string& calibration_id() const { return calibration_id_; }
  /// Mean of the picture centres: the natural centre of rotation, Reference frame, mm.
  [[nodiscard]] Point<frames::Reference> centroid() const;

 private:
  Sweep(std::vector<TrackedFrame> frames, std::string calibration_id)
      : frames_(std::move(frames)), calibration_id_(std::move(calibration_id)) {}
  std::vector<TrackedFrame> frames_;
  std::string calibration_id_;
};

}  // namespace nav
