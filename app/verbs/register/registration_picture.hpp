// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "render/canvas.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// What the picture of a registration is written as.
inline constexpr const char* kRegistrationPicture = "registration.png";

/// One ultrasound picture of a sweep beside checkerboards of it with the CT, before and after
/// registration: structures that run on across the squares are aligned. One that was not accepted
/// is captioned as refused, in red.
Image2d<Rgba8> registration_picture(const Volume& ct, const TrackedFrame& frame,
                                    const Transform<frames::Ct, frames::Reference>& before,
                                    const Transform<frames::Ct, frames::Reference>& after,
                                    bool accepted, const render::HuWindow& window);

}  // namespace nav::app
