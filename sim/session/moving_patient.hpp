// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/transform.hpp"
#include "nav/ultrasound_frame.hpp"
#include "sim/motion/breathing.hpp"

namespace nav::sim {

/// Where a picture lies in the patient at rest.
struct RestView {
  /// Rigid map that comes nearest to where the picture's points were at rest, least squares.
  Transform<frames::Ct, frames::Image> ct_from_image;
  double deformation_rms_mm;  ///< What the rigid map leaves over, across the picture.
};

/// The picture's points are spread over its rectangle (or sector), 7 x 7.
RestView rest_view(const Warp& warp, const Transform<frames::Ct, frames::Image>& ct_from_image,
                   const PixelGrid& grid, int width, int height);

}  // namespace nav::sim
