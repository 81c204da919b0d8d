// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/ultrasound_image.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav {

PixelGrid PixelGrid::centred(int width, double spacing_x_mm, double spacing_y_mm) {
  PixelGrid grid;
  grid.mm_per_pixel << spacing_x_mm, 0, 0, spacing_y_mm;
  grid.origin_mm << -0.5 * (width - 1) * spacing_x_mm, 0;
  return grid;
}

Point<frames::Image> PixelGrid::at(double column, double row) const {
  const Eigen::Vector2d p = origin_mm + mm_per_pixel * Eigen::Vector2d(column, row);
  return {{p.x(), p.y(), 0.0}};
}

Eigen::Vector2d PixelGrid::pixel_of(const Point<frames::Image>& p) const {
  return mm_per_pixel.inverse() * (p.mm.head<2>() - origin_mm);
}

double PixelGrid::shear_rad() const {
  const Eigen::Vector2d a = mm_per_pixel.col(0).normalized();
  const Eigen::Vector2d b = mm_per_pixel.col(1).normalized();
  return std::asin(std::clamp(std::abs(a.dot(b)), 0.0, 1.0));
}

Result<void> validate(const PixelGrid& grid) {
  constexpr double kMinSpacingMm = 1e-4;
  constexpr double kMaxSpacingMm = 100.0;
  constexpr double kMaxShearRad = 0.35;  // 20 degrees; calibrations are far below.
  if (!grid.mm_per_pixel.allFinite() || !grid.origin_mm.allFinite()) {
    return Error{ErrorCode::kMalformedData,
                 "pixel grid: expected finite numbers, found NaN or Inf"};
  }
  for (int axis = 0; axis < 2; ++axis) {
    const double spacing = grid.mm_per_pixel.col(axis).norm();
    if (spacing < kMinSpacingMm || spacing > kMaxSpacingMm) {
      std::ostringstream text;
      text << "pixel grid: expected a spacing of " << kMinSpacingMm << " to " << kMaxSpacingMm
           << " mm per pixel along axis " << axis << ", found " << spacing;
      return Error{ErrorCode::kMalformedData, text.str()};
    }
  }
  if (grid.shear_rad() > kMaxShearRad) {
    std::ostringstream text;
    text << "pixel grid: expected rows and columns within 20 degrees of orthogonal, found "
         << grid.shear_rad() * 180.0 / M_PI << " degrees";
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  return {};
}

bool SectorOutline::contains(const Eigen::Vector2d& p_image_mm) const {
  const Eigen::Vector2d d = p_image_mm - apex_mm;
  const double radius = d.norm();
  return radius >= radius_min_mm && radius <= radius_max_mm && d.y() > 0 &&
         std::abs(std::atan2(d.x(), d.y())) <= half_angle_rad;
}

void set_colours(UltrasoundImage& frame, Image2d<Rgb8> image) {
  frame.pixels = luma(image);
  frame.colours = has_colours(image) ? std::move(image) : Image2d<Rgb8>();
}

std::pair<Eigen::Vector2d, Eigen::Vector2d> box_mm(const UltrasoundImage& frame) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const double column : {0.0, frame.pixels.width() - 1.0}) {
    for (const double row : {0.0, frame.pixels.height() - 1.0}) {
      const Eigen::Vector2d p = frame.grid.at(column, row).mm.head<2>();
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  return {low, high};
}

double extent_mm(const UltrasoundImage& frame) {
  const auto [low, high] = box_mm(frame);
  return (high - low).norm();
}

}  // namespace nav
