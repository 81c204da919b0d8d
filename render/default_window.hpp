// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "nav/volume.hpp"
#include "render/slice.hpp"

namespace nav::render {

/// The grey window for a flat picture that shows some values of a volume (ADR 51). Of Hounsfield
/// units a customary one: lung (-500, 1500) where most of what is not air is lung, vessels and bone
/// (200, 700) where a fifth of the tissue would be white as soft tissue, else soft tissue (60,
/// 400). Of other values (MR) one for the whole volume, outliers left out. shown: HU, finite.
HuWindow default_window(const Volume& volume, std::span<const float> shown);

}  // namespace nav::render
