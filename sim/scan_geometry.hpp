// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "nav/ultrasound_image.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Scan line in the image plane, mm.
struct ScanLine {
  Eigen::Vector2d start;
  Eigen::Vector2d direction;  ///< Unit vector.
};

/// Positions of the scan lines and pixels of a probe. Private to sim/.
class ScanGeometry {
 public:
  explicit ScanGeometry(const ProbeModel& probe);

  [[nodiscard]] ScanLine line(int index) const;
  /// Continuous line and sample index of a point in the plane, also outside the field.
  [[nodiscard]] Eigen::Vector2d beam_of(const Eigen::Vector2d& p) const {
    return beam_of<double>(p);
  }
  /// beam_of() in the precision of S; in float within 0.005 of a line and of a sample.
  template <class S>
  [[nodiscard]] Eigen::Matrix<S, 2, 1> beam_of(const Eigen::Matrix<S, 2, 1>& p) const;
  /// Distance between neighbouring lines at a distance from the face.
  [[nodiscard]] double line_spacing_mm(double along_mm) const;
  [[nodiscard]] int samples() const { return samples_; }
  [[nodiscard]] double sample_mm() const { return sample_mm_; }
  [[nodiscard]] const PixelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::optional<SectorOutline>& outline() const { return outline_; }

  /// Image from grey values of lines x samples (bilinear); black outside the field.
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
  double half_lines_ = 0.5 * (probe_.lines - 1);
  double samples_per_mm_ = 1.0 / sample_mm_;
  double shares_per_mm_ = 2 / probe_.width_mm;  ///< Share of half of the face or angle.
  double shares_per_rad_ = 1 / probe_.half_angle_rad;
  int samples_;
  PixelGrid grid_;
  std::optional<SectorOutline> outline_;
  std::vector<Tap> taps_;
};

inline double angle_of(double x, double y) { return std::atan2(x, y); }
/// Angle within 1.2e-5 rad (Abramowitz and Stegun 4.4.47), in a third of the time of atan2.
inline float angle_of(float x, float y) {
  constexpr float kHalfPi = 1.5707963F;
  const float a = std::abs(x), b = std::abs(y);
  const float t = std::min(a, b) / std::max({a, b, 1e-30F});
  const float s = t * t;
  const float small =
      t * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + s * 0.0208351F))));
  const float first = a > b ? kHalfPi - small : small;
  return std::copysign(y < 0 ? 2 * kHalfPi - first : first, x);
}

template <class S>
Eigen::Matrix<S, 2, 1> ScanGeometry::beam_of(const Eigen::Matrix<S, 2, 1>& p) const {
  const auto lines = static_cast<S>(half_lines_);
  const auto per_sample = static_cast<S>(samples_per_mm_);
  if (probe_.kind == ProbeKind::kLinear) {
    const S share = p.x() * static_cast<S>(shares_per_mm_);
    return {lines * (share + 1), per_sample * p.y()};
  }
  const Eigen::Matrix<S, 2, 1> q = p - outline_->apex_mm.template cast<S>();
  const S share = angle_of(q.x(), q.y()) * static_cast<S>(shares_per_rad_);
  return {lines * (share + 1), per_sample * (q.norm() - static_cast<S>(outline_->radius_min_mm))};
}

}  // namespace nav::sim
