// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/transform.hpp"
#include "nav/ultrasound_image.hpp"
#include "sim/motion/breathing.hpp"

namespace nav::sim {

/// Pose of an image in the patient at rest.
struct RestView {
  /// Rigid map nearest, by least squares, to the positions of the image's points at rest.
  Transform<frames::Ct, frames::Image> ct_from_image;
  double deformation_rms_mm;  ///< RMS difference from the rigid map over the image.
};

/// Computes the view at rest from 7 x 7 points over the image's rectangle (or sector).
RestView rest_view(const Warp& warp, const Transform<frames::Ct, frames::Image>& ct_from_image,
                   const PixelGrid& grid, int width, int height);

}  // namespace nav::sim
