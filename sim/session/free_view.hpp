// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// A face that leans more off the skin loses contact at one side.
inline constexpr double kMostLeanRad = 0.35;

/// How far a face is pushed into the skin, mm: a curved one deeper.
double press_mm(ProbeKind probe);

/// A view with its face pressed press_mm into the skin along the beam; nothing where it leans more
/// than kMostLeanRad off the skin, or lies nowhere near it.
std::optional<Transform<frames::Ct, frames::Image>> settled(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& view, double press_mm);

/// A view of the patient's targets from the skin, free of what sound does not pass and upright on
/// the skin as far as there is one: the probe pressed press_mm into the skin, its picture across
/// the body. kUsage when the patient has no skin around the targets.
Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm);

}  // namespace nav::sim
