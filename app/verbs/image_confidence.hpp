// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/ultrasound_image.hpp"
#include "tracking/reconstruction/image_area.hpp"

namespace nav::app {

/// Confidence of the pixels of one ultrasound image, 0 to 255 for 0 to 1: the random walks of
/// Karamalis et al. 2012 along the image's scan lines (render/features/confidence.hpp, with its
/// usual parameters). Pixels outside the area, and those that no scan line reaches, have 0. Errors:
/// those of the solver, with the number of the image.
Result<Image2d<std::uint8_t>> image_confidence(const UltrasoundImage& image,
                                               const tracking::ImageArea& area, int threads);

}  // namespace nav::app
