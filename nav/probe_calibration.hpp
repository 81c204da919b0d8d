// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nav/transform.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav {

/// Size and pixel grid of the images of a probe, apart from where they lie on the probe.
struct ImageGeometry {
  int width = 0, height = 0;  ///< Pixels.
  PixelGrid grid;
  std::optional<SectorOutline> outline = std::nullopt;

  /// Depth of the image, mm: from the first to the last row.
  [[nodiscard]] double depth_mm() const;
  /// "640 × 480 pixels of 0.120 × 0.120 mm".
  [[nodiscard]] std::string description() const;
};
ImageGeometry geometry_of(const UltrasoundImage& image);
/// True for the same size in pixels, and pixels that differ by less than 0.1 % of their spacing.
bool same_pixels(const ImageGeometry& a, const ImageGeometry& b);

/// Position of the images of one geometry on the probe. A change of the scanner's depth or zoom
/// makes another geometry, for which this calibration does not hold.
struct ProbeCalibration {
  Transform<frames::Probe, frames::Image> probe_from_image;
  /// Geometry of the images that the calibration was made with; absent: it holds for every image.
  std::optional<ImageGeometry> geometry = std::nullopt;
  std::string doubt{};  ///< Why it is not to be relied on, one sentence; empty when it is.

  [[nodiscard]] bool fits(const ImageGeometry& images) const {
    return !geometry || same_pixels(*geometry, images);
  }
};

}  // namespace nav
