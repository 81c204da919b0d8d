// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "app/options/session_config.hpp"
#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// Values of a CT, HU, at points spread over a picture in it; none of points outside the CT.
/// picture_mm: Image frame.
std::vector<float> values_along(const Volume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const Eigen::AlignedBox2d& picture_mm);
std::vector<float> values_along(const Volume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const UltrasoundFrame& picture);
/// The same of all pictures of a sweep.
std::vector<float> values_along(const Volume& ct,
                                const Transform<frames::Ct, frames::Reference>& ct_from_reference,
                                std::span<const TrackedFrame> pictures);

/// The grey window of flat pictures of a CT: what the session says, else render::default_window()
/// for the values that they show.
render::HuWindow ct_window(const SessionConfig::View& said, const Volume& ct,
                           std::span<const float> shown);

}  // namespace nav::app
