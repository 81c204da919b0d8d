// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Largest angle between beam and skin normal; beyond it the face loses contact at one side.
inline constexpr double kMostLeanRad = 0.35;

/// Depth by which a face is pressed into the skin, mm; a curved one deeper.
double press_mm(ProbeKind probe);

/// View with its face pressed press_mm into the skin along the beam. Nothing when it leans more
/// than kMostLeanRad off the skin, or when no skin is near it.
std::optional<Transform<frames::Ct, frames::Image>> settled(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& view, double press_mm);

/// View of the patient's targets from the skin, as free as possible of tissue that blocks sound,
/// and as upright on the skin as possible. The probe is pressed press_mm into the skin, and its
/// image is across the body. kUsage when the patient has no skin around the targets.
Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm);

}  // namespace nav::sim
