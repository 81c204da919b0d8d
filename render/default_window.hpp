// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "nav/volume.hpp"
#include "render/slices/slice.hpp"

namespace nav::render {

/// Air around the body, and padding, lie below this value.
inline constexpr float kAirBelowHu = -950;
inline constexpr HuWindow kLungWindow{-500, 1500};

/// The grey window for a flat image that shows some values of a volume (ADR 51). For Hounsfield
/// units it is a customary window:
/// - lung (-500, 1500) if most of what is not air is lung;
/// - vessels and bone (200, 700) if a fifth of the tissue would be white in the soft tissue window;
/// - else soft tissue (60, 400).
/// Other values (MR) have one window for the whole volume, without outliers. \p shown: HU, finite.
HuWindow default_window(const StoredVolume& volume, std::span<const float> shown);

}  // namespace nav::render
