// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "render/canvas.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// File name of a registration's image.
inline constexpr const char* kRegistrationImage = "registration.png";

/// Draws an ultrasound image of a sweep beside checkerboards of it with the CT, before and after
/// registration. Structures that continue across the squares are aligned. A registration that was
/// not accepted has the caption "refused", in red.
Image2d<Rgba8> registration_image(const Volume& ct, const TrackedImage& frame,
                                  const Transform<frames::Ct, frames::Reference>& before,
                                  const Transform<frames::Ct, frames::Reference>& after,
                                  bool accepted, const render::HuWindow& window);

}  // namespace nav::app
