// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/ultrasound_image.hpp"

namespace nav::devices {

/// Shape of the sector that a mechanical probe scans: lines at equal angles about an apex.
struct SectorShape {
  double radius_mm = 0;     ///< From the apex to the first sample, [0, 200].
  double depth_mm = 0;      ///< From the first sample to the last, (0, 500].
  double angle_deg = 0;     ///< Between the first line and the last, (0, 170].
  double spacing_mm = 0.2;  ///< Between pixels, [0.05, 2].
};
/// Rejects values out of range, and shapes of more than 4096 pixels a side.
Result<void> validate(const SectorShape& shape);

/// Makes images of scan lines. A pixel takes the mean of the four samples around it, weighted by
/// distance along the line and across the lines; outside of the sector it is 0. The Image frame has
/// its origin in the middle of the first row, which touches the ends of the transducer's arc.
class SectorScan {
 public:
  /// \p lines: of an image, from the side with the lowest column, >= 2; \p samples: of a line,
  /// >= 2. Precondition: a valid shape, otherwise a Bug.
  SectorScan(const SectorShape& shape, std::size_t lines, std::size_t samples);
  /// \p samples: line by line. Precondition: lines x samples values, otherwise a Bug.
  [[nodiscard]] Image2d<std::uint8_t> convert(std::span<const std::uint8_t> samples) const;
  [[nodiscard]] const PixelGrid& grid() const { return grid_; }
  [[nodiscard]] const SectorOutline& outline() const { return outline_; }

 private:
  /// Samples of one pixel: the first of four, and the weights of the second line and sample.
  struct Source {
    std::uint32_t pixel = 0, sample = 0;
    float across = 0, along = 0;
  };
  std::size_t lines_, samples_;
  int width_ = 0, height_ = 0;
  PixelGrid grid_;
  SectorOutline outline_;
  std::vector<Source> sources_;  ///< For each pixel inside.
};

}  // namespace nav::devices
