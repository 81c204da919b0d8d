// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "nav/ultrasound_image.hpp"

namespace nav::tracking {

/// Rectangle and fan that PLUS cuts out of every image (VolumeReconstruction of a configuration),
/// in pixels, and so independent of the calibration.
struct PlusClip {
  struct Rectangle {
    Eigen::Vector2d origin_px;  ///< Column and row of its first corner.
    Eigen::Vector2d size_px;    ///< A pixel at origin + size still belongs to it.
  };
  struct Fan {
    Eigen::Vector2d origin_px;
    double low_rad, high_rad;  ///< Angles about +y (down), in (-pi/2, pi/2).
    double radius_start_px, radius_stop_px;
  };
  std::optional<Rectangle> rectangle = std::nullopt;
  std::optional<Fan> fan = std::nullopt;
};

/// Rejects values that are not finite, a rectangle or fan without extent, and angles outside
/// (-90, 90) degrees.
Result<void> validate(const PlusClip& clip);

/// Pixels of an image that are echoes: those inside the clip and the sector that its probe
/// insonified. Built once for all images of one geometry.
class ImageArea {
 public:
  /// Columns [first, past) of one row.
  struct Run {
    int row, first, past;
  };
  /// Takes the outline of the image as the sector.
  ImageArea(const UltrasoundImage& image, const PlusClip& clip);

  /// True for images of the size, pixel grid and outline that it was built for.
  [[nodiscard]] bool fits(const UltrasoundImage& image) const;
  /// Row by row, in order.
  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  /// Pixel inside the image. Thread-safe.
  [[nodiscard]] bool contains(int column, int row) const {
    return mask_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(column)] != 0;
  }
  [[nodiscard]] bool empty() const { return runs_.empty(); }
  [[nodiscard]] std::size_t pixel_count() const { return pixels_; }
  /// Corners of the clip rectangle, or of the box around all pixels of the area where there is no
  /// rectangle: four positions (column, row).
  [[nodiscard]] std::vector<Eigen::Vector2d> corners() const;
  /// Apex of the scan lines and radius of depth 0, Image frame, mm; absent: parallel lines along
  /// +y, depth 0 at y = 0.
  struct Apex {
    Eigen::Vector2d mm;
    double radius_mm;
  };
  [[nodiscard]] const std::optional<Apex>& apex() const { return apex_; }

 private:
  int width_, height_;
  PixelGrid grid_;
  std::optional<SectorOutline> outline_;
  Eigen::Vector2d low_px_, high_px_;
  std::vector<std::uint8_t> mask_;
  std::vector<Run> runs_;
  std::size_t pixels_ = 0;
  std::optional<Apex> apex_;
};

}  // namespace nav::tracking
