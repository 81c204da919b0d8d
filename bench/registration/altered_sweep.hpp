// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "nav/sweep.hpp"

/// Functions that copy a sweep and change it in one respect.
namespace nav::bench {

/// Changes the pixels of every ultrasound image.
Sweep with_pixels(
    const Sweep& sweep,
    const std::function<void(std::vector<std::uint8_t>&, const UltrasoundImage&)>& change);

/// Scales the pixel size, and the outline, by \p factor without changing the image content. factor:
/// > 0.
Sweep enlarged(const Sweep& sweep, double factor);

/// Draws echoes at \p factor times their true depth along the beam, from the transducer's face: a
/// scanner that assumes a speed of sound too high by this factor. factor: > 0. Echoes beyond the
/// depth of the images are lost; pixels without an echo are black and outside the outline.
Sweep deepened(const Sweep& sweep, double factor);

/// Delays the images relative to their poses by \p delay; negative: they are early. Each image has
/// the pose, interpolated in the sweep, of the moment \p delay before it; images without such a
/// moment are left out. Precondition: the sweep is longer than the delay.
Sweep delayed(const Sweep& sweep, Duration delay);

/// Moves the images relative to the probe: translates them and rotates them about the middle of the
/// transducer's face, each in a seeded direction.
Sweep miscalibrated(const Sweep& sweep, double shift_mm, double turn_rad, std::uint64_t seed);

/// Translates the images relative to the probe along their width, depth and normal.
Sweep shifted(const Sweep& sweep, const Eigen::Vector3d& shift_mm);

}  // namespace nav::bench
