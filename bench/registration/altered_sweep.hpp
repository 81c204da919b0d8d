// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "nav/sweep.hpp"

/// Sweeps that are changed in one respect.
namespace nav::bench {

/// With every picture's pixels changed.
Sweep with_pixels(
    const Sweep& sweep,
    const std::function<void(std::vector<std::uint8_t>&, const UltrasoundFrame&)>& change);

/// With pixels, and an outline, that claim to be so many times as large as they are. factor: > 0.
Sweep enlarged(const Sweep& sweep, double factor);

/// With echoes that are drawn so many times as deep as they came from, along the beam from the
/// transducer's face: a scanner that takes sound to be so much faster than it is. factor: > 0. What
/// lies deeper than the pictures is lost; what they would need from there is black and outside
/// their outline.
Sweep deepened(const Sweep& sweep, double factor);

/// With pictures that are so much later than their poses say, negative: earlier. Each has the pose,
/// between those of the sweep, of the moment so long before it; those without such a moment are
/// left out. Precondition: the sweep is longer than the delay.
Sweep delayed(const Sweep& sweep, Duration delay);

/// With pictures that are taken to lie elsewhere on the probe than they do: shifted and, about the
/// middle of the transducer's face, turned, each in a seeded direction.
Sweep miscalibrated(const Sweep& sweep, double shift_mm, double turn_rad, std::uint64_t seed);

/// The same, shifted alone: along width, depth and normal of the pictures.
Sweep shifted(const Sweep& sweep, const Eigen::Vector3d& shift_mm);

}  // namespace nav::bench
