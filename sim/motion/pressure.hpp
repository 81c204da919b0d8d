// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/transform.hpp"
#include "sim/motion/warp.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Largest pressure that pressed_by() takes, mm.
inline constexpr double kMostPressureMm = 12;

/// Displacement of the tissue by a probe that is pressed into the skin: by \p pressure_mm along the
/// beam under the middle of the face, less with the depth (a Gaussian of 25 mm) and to the sides
/// (0.6 of the face's width, 15 mm across the image). One-to-one, because its steepness is at most
/// 0.5. Precondition: 0 < pressure_mm <= kMostPressureMm, otherwise a Bug.
std::shared_ptr<const Warp> pressed_by(const Transform<frames::Ct, frames::Image>& ct_from_image,
                                       const ProbeModel& probe, double pressure_mm);

}  // namespace nav::sim
