// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nav/image.hpp"
#include "nav/volume.hpp"

namespace nav::render {

/// Grey window of a CT slice: black at level − width/2, white at level + width/2, HU.
struct HuWindow {
  double level = 60;
  double width = 400;
};

/// CT along the ultrasound plane. Pixel (column, row) shows the point of the Image frame
/// origin_mm + mm_per_pixel · (column, row), trilinear; outside the CT the pixel is absent (alpha
/// 0). Grey = round(255 · clamp((HU − level) / width + ½)).
Image2d<Rgba8> reslice(const Volume& ct, const Transform<frames::Ct, frames::Image>& ct_from_image,
                       const Eigen::Vector2d& origin_mm, double mm_per_pixel, int width, int height,
                       const HuWindow& window);

}  // namespace nav::render
