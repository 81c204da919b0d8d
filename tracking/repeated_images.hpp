// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav::tracking {

/// Finds images that repeat the image before to the last byte while the probe moves: the scanner is
/// frozen, or a frame grabber repeats. An image of one value has nothing to repeat. Not
/// thread-safe.
class RepeatedImages {
 public:
  /// \p diagnostics hears of each image that begins to be repeated; it must outlive this.
  explicit RepeatedImages(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  /// Judges the next image, which has pixels. Returns a sentence when it repeats an image at which
  /// the probe was more than 1 mm or 1 degree away; otherwise an empty text.
  std::string doubt(const UltrasoundFrame& image,
                    const Transform<frames::Tracker, frames::Probe>& tracker_from_probe);

 private:
  Diagnostics& diagnostics_;
  Image2d<std::uint8_t> pixels_;
  std::optional<Transform<frames::Tracker, frames::Probe>> first_;  ///< Pose at its first copy.
  Timestamp since_{};
  bool said_ = false;
};

}  // namespace nav::tracking
