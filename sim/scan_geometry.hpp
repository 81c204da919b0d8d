// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "nav/ultrasound_frame.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// One scan line in the image plane, mm.
struct ScanLine {
  Eigen::Vector2d start;
  Eigen::Vector2d direction;  ///< Unit.
};

/// Where scan lines and pixels of a probe lie. Private to sim/.
class ScanGeometry {
 public:
  explicit ScanGeometry(const ProbeModel& probe);

  [[nodiscard]] ScanLine line(int index) const;
  /// Line and sample, both continuous, of a point of the plane; also outside the field.
  [[nodiscard]] Eigen::Vector2d beam_of(const Eigen::Vector2d& p) const;
  /// Between neighbouring lines at a distance from the face.
  [[nodiscard]] double line_spacing_mm(double along_mm) const;
  [[nodiscard]] int samples() const { return samples_; }
  [[nodiscard]] double sample_mm() const { return sample_mm_; }
  [[nodiscard]] const PixelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::optional<SectorOutline>& outline() const { return outline_; }

  /// Picture from grey values of lines x samples (bilinear); black outside the field.
  [[nodiscard]] Image2d<std::uint8_t> convert(std::span<const float> grey) const;

 private:
  struct Tap {
    std::int32_t first = -1;  ///< Offset of (line, sample); -1: outside the field.
    float line_share = 0;
    float sample_share = 0;
  };
  void place_taps();

  ProbeModel probe_;
  double sample_mm_;
  int samples_;
  PixelGrid grid_;
  std::optional<SectorOutline> outline_;
  std::vector<Tap> taps_;
};

}  // namespace nav::sim
