// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/scan_geometry.hpp"

#include <cmath>
#include <tbb/parallel_for.h>

namespace nav::sim {
namespace {

/// The range resolution follows the wavelength: about 0.26 mm between samples at 3.5 MHz.
constexpr double kSampleMmTimesMhz = 0.9;

/// Distance from the apex to the face.
double face_radius_mm(const ProbeModel& probe) {
  return probe.kind == ProbeKind::kSector ? 0.0 : probe.radius_mm;
}

PixelGrid image_grid(const ProbeModel& probe) {
  double width = probe.width_mm;
  double top = 0;
  if (probe.kind != ProbeKind::kLinear) {
    const double radius = face_radius_mm(probe);
    width = 2 * (radius + probe.depth_mm) * std::sin(probe.half_angle_rad);
    // The ends of a curved face lie above its centre, which is the origin.
    top = -radius * (1 - std::cos(probe.half_angle_rad));
  }
  const double spacing =
      std::max(width / (probe.columns - 1), (probe.depth_mm - top) / (probe.rows - 1));
  PixelGrid grid = PixelGrid::centred(probe.columns, spacing, spacing);
  grid.origin_mm.y() = top;
  return grid;
}

}  // namespace

ScanGeometry::ScanGeometry(const ProbeModel& probe)
    : probe_(probe),
      sample_mm_(kSampleMmTimesMhz / probe.frequency_mhz),
      samples_(static_cast<int>(probe.depth_mm / sample_mm_) + 1),
      grid_(image_grid(probe)) {
  if (probe.kind != ProbeKind::kLinear) {
    const double radius = face_radius_mm(probe);
    outline_ = SectorOutline{
        {0, -radius}, radius, radius + (samples_ - 1) * sample_mm_, probe.half_angle_rad};
  }
  place_taps();
}

ScanLine ScanGeometry::line(int index) const {
  const double share = 2.0 * index / (probe_.lines - 1) - 1.0;
  if (probe_.kind == ProbeKind::kLinear) return {{0.5 * share * probe_.width_mm, 0}, {0, 1}};
  const double angle = share * probe_.half_angle_rad;
  const Eigen::Vector2d direction(std::sin(angle), std::cos(angle));
  const double radius = face_radius_mm(probe_);
  return {Eigen::Vector2d(0, -radius) + radius * direction, direction};
}

double ScanGeometry::line_spacing_mm(double along_mm) const {
  if (probe_.kind == ProbeKind::kLinear) return probe_.width_mm / (probe_.lines - 1);
  const double spacing =
      (face_radius_mm(probe_) + along_mm) * 2 * probe_.half_angle_rad / (probe_.lines - 1);
  constexpr double kLeastMm = 0.02;  // The lines of a sector meet at the apex.
  return std::max(spacing, kLeastMm);
}

void ScanGeometry::place_taps() {
  taps_.resize(static_cast<std::size_t>(probe_.columns) * static_cast<std::size_t>(probe_.rows));
  constexpr double kRounding = 1e-6;
  for (int row = 0; row < probe_.rows; ++row) {
    for (int column = 0; column < probe_.columns; ++column) {
      const Eigen::Vector2d p = grid_.at(column, row).mm.head<2>();
      const Eigen::Vector2d beam = beam_of(p);
      const double line = beam.x();
      const double sample = beam.y();
      if (line < -kRounding || line > probe_.lines - 1 + kRounding || sample < -kRounding ||
          sample > samples_ - 1 + kRounding) {
        continue;
      }
      const int l = std::clamp(static_cast<int>(line), 0, probe_.lines - 2);
      const int s = std::clamp(static_cast<int>(sample), 0, samples_ - 2);
      taps_[static_cast<std::size_t>(row * probe_.columns + column)] = {
          l * samples_ + s, static_cast<float>(line - l), static_cast<float>(sample - s)};
    }
  }
}

Image2d<std::uint8_t> ScanGeometry::convert(std::span<const float> grey) const {
  std::vector<std::uint8_t> pixels(taps_.size());
  const auto columns = static_cast<std::size_t>(probe_.columns);
  const auto next_line = static_cast<std::size_t>(samples_);
  tbb::parallel_for(std::size_t{0}, static_cast<std::size_t>(probe_.rows), [&](std::size_t row) {
    for (std::size_t i = row * columns; i < (row + 1) * columns; ++i) {
      const Tap& tap = taps_[i];
      if (tap.first < 0) continue;
      const float* g = grey.data() + tap.first;
      const float near = g[0] + tap.sample_share * (g[1] - g[0]);
      const float far = g[next_line] + tap.sample_share * (g[next_line + 1] - g[next_line]);
      const float value = near + tap.line_share * (far - near);
      pixels[i] = static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
    }
  });
  return {probe_.columns, probe_.rows, std::move(pixels)};
}

}  // namespace nav::sim
