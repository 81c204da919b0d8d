// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/ray_spec_surfaces.hpp"
#include "render/ray_spec_volume.hpp"

/// The one specification of a picture. The reference engine runs it in double; the CPU engine
/// prepares its rays and surfaces with it; the GLSL of shaders/ mirrors it line by line.
///
/// Coordinates. "Local mm" are CT axes (LPS, mm) minus grid.origin_mm, subtracted in double before
/// anything else, so that a CT far from the world's origin costs no digits. "Index" is the
/// continuous voxel index: index = (directionsᵀ · local) ∘ 1/spacing.
///
/// Ray. Pixel (x, y), row 0 at the top, is seen along the ray through its centre; t is the distance
/// from the ray's origin in mm, t >= 0. Perspective: origin = eye. Orthographic: origin on the
/// plane through the eye.
///
/// Box. The volume fills the box of its voxel centres, [0, n - 1] per axis. An axis with a single
/// voxel has no thickness there, so it fills half a voxel either side, [-1/2, 1/2], and its value
/// does not change along it.
///
/// Cells. h = quality.step_voxels · min(spacing). Cell k covers t in [k h, (k + 1) h), for every
/// ray and every scene: a global lattice. Its value is the trilinear HU at t = (k + 1/2) h, the
/// index clamped to [0, n - 1] per axis. Its extinction acts over the length of the cell that lies
/// between the events of the ray (entry, surfaces, exit), so faces, planes and needles cut exactly:
///   alpha = -expm1(-tau(hu) · length_mm).
///
/// Colour. rgb(hu), shaded if shading.enabled by shade() with the gradient at the same point.
///
/// Gradient. Central difference one voxel either way along each index axis, positions clamped to
/// [0, n - 1], divided by 2 · spacing_mm, turned by directions: HU per mm along the CT axes.
///
/// Compositing, front to back, premultiplied: C += (1 - A) · alpha · rgb; A += (1 - A) · alpha.
/// Surfaces are samples of their own alpha at their exact t, sorted by t (equal t: plane, needle,
/// spheres in order); the first of alpha 1 ends the ray. A surface is drawn if t > 0, inside the
/// volume or not. Early termination: the ray ends once A >= quality.opaque_at (< 1).
/// The pixel is C + (1 - A) · background, alpha 1.
namespace nav::render::spec {}
