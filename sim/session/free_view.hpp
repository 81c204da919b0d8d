// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/plan.hpp"
#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Largest angle between beam and skin normal; beyond it the face loses contact at one side.
inline constexpr double kMostLeanRad = 0.35;

/// Depth by which a face is pressed into the skin, mm; a curved one deeper. Negative: distance of
/// the face from the skin, with a gel pad between them.
double press_mm(const ProbeModel& probe);

/// View with its face pressed press_mm into the skin along the beam. Nothing when it leans more
/// than kMostLeanRad off the skin, or when no skin is near it.
std::optional<Transform<frames::Ct, frames::Image>> settled(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& view, double press_mm);

/// View of the patient's targets from the skin, as free as possible of tissue that blocks sound,
/// and as upright on the skin as possible. The probe is pressed press_mm into the skin, and its
/// image is across the body. kUsage when the patient has no skin around the targets.
Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm);

/// View of a needle's planned path: the path lies in the image plane, its target on the middle line
/// and its entry at the image's -x side, beside the probe. The line from the face to the target is
/// free of tissue that blocks sound; otherwise the preferences of free_view(). kUsage when there is
/// no such view.
Result<Transform<frames::Ct, frames::Image>> approach_view(const Anatomy& patient,
                                                           const NeedlePlan& plan,
                                                           const ProbeModel& probe);

}  // namespace nav::sim
