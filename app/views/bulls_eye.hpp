// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "app/views/slice_view.hpp"

namespace nav::app {

/// Radii of the rings of a bull's-eye, mm.
inline constexpr std::array<double, 4> kBullsEyeRingsMm{5, 10, 20, 50};

/// The plane of a bull's-eye: across the planned path, through the target, turned as a radiological
/// slice of that direction. Its scale shows the tip and the point that the needle points at, in one
/// of four steps.
SliceGeometry bulls_eye_geometry(const NeedlePlan& plan,
                                 const Transform<frames::Ct, frames::Needle>& ct_from_needle,
                                 PixelSize size);

/// The view along the planned path: rings about the path, the target, the tip (dot), and the point
/// in the target's plane that the needle points at (ring). Empty without numbers: a bull's-eye is
/// read as a number.
SliceDrawing draw_bulls_eye(const PanelContext& context, PixelSize size, double ratio);

}  // namespace nav::app
