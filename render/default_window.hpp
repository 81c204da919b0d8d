// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "nav/volume.hpp"
#include "render/slices/slice.hpp"

namespace nav::render {

/// Air about a body, and padding, lie below.
inline constexpr float kAirBelowHu = -950;
/// What is below is air or lung, whatever the scanner's noise.
inline constexpr int kLeastTissueHu = -200;
inline constexpr HuWindow kLungWindow{-500, 1500};

/// CT has air, lung or gas in every body; MR and ultrasound have no such values.
bool is_hounsfield(const Volume& volume);

/// The grey window for a flat picture that shows some values of a volume (ADR 51). Of Hounsfield
/// units a customary one: lung (-500, 1500) where most of what is not air is lung, vessels and bone
/// (200, 700) where a fifth of the tissue would be white as soft tissue, else soft tissue (60,
/// 400). Of other values (MR) one for the whole volume, outliers left out. shown: HU, finite.
HuWindow default_window(const Volume& volume, std::span<const float> shown);

}  // namespace nav::render
