// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/slices/slice.hpp"

namespace nav::bench {

/// Camera with a field of view of 30 degrees and superior up. at: the point that it looks at, LPS
/// mm. from: direction from there to the eye.
render::Camera looking(const Eigen::Vector3d& at, const Eigen::Vector3d& from, double distance_mm);

/// A coronal image of a volume itself, valid, as the textured plane of Burns et al. 2007, Figure 5.
/// centre: LPS mm. width_mm × height_mm with 0.45 mm for each pixel.
render::UltrasoundPlane coronal_slice(const Volume& volume, const Eigen::Vector3d& centre,
                                      double width_mm, double height_mm, render::HuWindow window);

}  // namespace nav::bench
