// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/probe_calibration.hpp"

#include <cstdio>

namespace nav {

double ImageGeometry::depth_mm() const {
  return (grid.at(0, height - 1.0) - grid.at(0, 0)).v.norm();
}

std::string ImageGeometry::description() const {
  char text[96];
  std::snprintf(text, sizeof text, "%d × %d pixels of %.3f × %.3f mm", width, height,
                grid.mm_per_pixel.col(0).norm(), grid.mm_per_pixel.col(1).norm());
  return text;
}

ImageGeometry geometry_of(const UltrasoundImage& image) {
  return {image.pixels.width(), image.pixels.height(), image.grid, image.outline};
}

bool same_pixels(const ImageGeometry& a, const ImageGeometry& b) {
  constexpr double kTolerance = 1e-3;
  if (a.width != b.width || a.height != b.height) return false;
  const double scale = a.grid.mm_per_pixel.cwiseAbs().maxCoeff();
  return (a.grid.mm_per_pixel - b.grid.mm_per_pixel).cwiseAbs().maxCoeff() <= kTolerance * scale;
}

}  // namespace nav
