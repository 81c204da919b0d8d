// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/scene.hpp"

namespace nav::render {

/// The point that a pixel of a scene's image shows: where the ray through it has met half of what
/// is visible along it, in volumes, with their cutaway, and on surfaces. Absent when hardly
/// anything is visible there: less than 2 % of the pixel. Casts one ray in double precision;
/// projections other than kComposite are looked at as if they were composited. x, y: pixel, row 0
/// at the top; a pixel outside the image is absent. Errors: those of validate(Scene).
Result<std::optional<Point<frames::Ct>>> visible_point(const Scene& scene, int x, int y);

}  // namespace nav::render
