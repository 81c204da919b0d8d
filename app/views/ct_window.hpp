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

/// CT values, HU, at points spread over an image that lies in the CT; points outside the CT are
/// left out. image_mm: extent of the image, Image frame.
std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const Eigen::AlignedBox2d& image_mm);
std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const UltrasoundImage& image);
/// CT values, HU, along all images of a sweep.
std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Reference>& ct_from_reference,
                                std::span<const TrackedImage> images);

/// Grey window for flat images of a CT: level and width of the session; where these are absent,
/// render::default_window() of the shown values.
render::HuWindow ct_window(const SessionConfig::View& said, const StoredVolume& ct,
                           std::span<const float> shown);

}  // namespace nav::app
