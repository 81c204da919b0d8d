// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav::tracking {

/// An image that shows what an earlier one showed.
struct RepeatedImage {
  std::string doubt;   ///< Sentence that says which one it repeats.
  Timestamp acquired;  ///< Acquisition of the image that it repeats.
};

/// Finds images that repeat one of the images before to the last byte while the probe moves: the
/// scanner is frozen, or a frame grabber repeats one image or alternates between some. An image of
/// one value has nothing to repeat. Not thread-safe.
class RepeatedImages {
 public:
  /// \p diagnostics hears of each image that begins to be repeated; it must outlive this.
  explicit RepeatedImages(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  /// Judges the next image, which has pixels. Absent, unless it repeats one of the newest different
  /// images, at which the probe was more than 1 mm or 1 degree away.
  std::optional<RepeatedImage> find(
      const UltrasoundImage& image,
      const Transform<frames::Tracker, frames::Probe>& tracker_from_probe);

 private:
  /// An image that came for the first time.
  struct First {
    Image2d<std::uint8_t> pixels;
    Transform<frames::Tracker, frames::Probe> tracker_from_probe;
    Timestamp acquired;
    bool said = false;
  };
  static constexpr std::size_t kMostKept = 4;

  Diagnostics& diagnostics_;
  std::deque<First> kept_;   ///< The newest different images, newest first.
  std::ptrdiff_t last_ = 0;  ///< The one of them that came last.
};

}  // namespace nav::tracking
