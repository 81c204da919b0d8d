// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/spec/ray_spec_cutaway.hpp"
#include "render/spec/ray_spec_surfaces.hpp"
#include "render/spec/ray_spec_volume.hpp"

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
/// ray and every scene: a global lattice; with quality.jitter [(k + u) h, (k + 1 + u) h), u =
/// jitter_of(pixel). Values are trilinear HU, the index clamped to [0, n - 1] per axis.
///   Pre-integrated: the cell's values run linearly from the value v0 at its begin to v1 at its
///   end. Post-classified: the cell has one value, that at its middle.
/// Events of the ray (entry, surfaces, exit) cut a cell to the part [a, b] of it, exactly, with the
/// values va, vb of the line from v0 to v1 there and the length (b - a) h.
///
/// Classification, by TransferTable, to extinction tau and colour:
///   pre-integrated: mean(va, vb, bow); post-classified: at(v).
/// The bow of a whole cell between lattice points k and k + 1 is that of the parabola through the
/// values at k - 1, k and k + 1, bow_of(): by how much its mean over the cell lies above that of
/// the line. 0 for a cell that is cut, for several cells taken as one, and unless k - 1 lies behind
/// the lattice point at or in front of the entry into the box.
/// Without it all errors of a ray have one sign, and noise is drawn too faint.
/// A function with gradient windows is always post-classified, with the gradient of the middle.
/// With quality.adaptive_error several cells may be taken as one: adaptive_step.hpp.
///
/// Cutaway (ray_spec_cutaway.hpp). A part that begins in front of T2 has at its ends the
/// visibilities V_a = visibility(I(va), Omega(a)) and V_b. Where they differ by no more than
/// kFadeVaries, tau is faded(tau, (V_a + V_b) / 2) and all else is as without a cutaway. Otherwise
/// the cell is the mean of kFadeSteps equidistant midpoints of the part: value v_j on its line,
/// Omega at its own t; tau_j = faded(tau, visibility(I(v_j), Omega_j)), colour weighted by tau_j.
///
/// Importance of a cell, needed only when shading.emphasis > 0: the mean of I(va) and I(vb) where
/// they differ by no more than kFadeVaries, else the mean of I weighted by tau over the kFadeSteps
/// midpoints, 1 when all of them are 0. Of a cell that is a mean of midpoints because its
/// visibility varies: the latter with tau_j, whatever I is.
///
/// Opacity of a cell: alpha = -expm1(-tau · length_mm).
///
/// Colour, shaded if shading.enabled by shade_sample() with the gradient at the cell's middle and
/// the share that the importance gives; share 0: no gradient. Pre-integrated: the mean of so
/// shading it at shades_of() places of the cell.
///
/// Gradient. Central difference one voxel either way along each index axis, positions clamped to
/// [0, n - 1], divided by 2 · spacing_mm, turned by directions: HU per mm along the CT axes.
///
/// Compositing, front to back, premultiplied: C += (1 - A) · alpha · rgb; A += (1 - A) · alpha.
/// Surfaces are samples of their own alpha at their exact t, sorted by t (equal t: plane, needle,
/// spheres in order, lines in order); the first of alpha 1 ends the ray. A surface is drawn if
/// t > 0, inside the volume or not. Early termination: the ray ends once A >= quality.opaque_at (<
/// 1), and what it has gathered stands for the rest, C / A: no channel is wrong by more than 1 - A,
/// and none always too dark. Otherwise the pixel is C + (1 - A) · background. Its alpha is 1.
///
/// Two volumes. With scene.ultrasound the CT and the ultrasound have cells each on its own lattice,
/// with its own h; H is the greater of the two. Where a ray runs through both boxes it is cut at
/// t = m H: what lies of the CT in slab m is composited in front of what lies there of the
/// ultrasound where m is even, behind it where m is odd, so that the order in depth is right to the
/// second order of H. The CT's part of a slab is composited for itself as above; then it is one
/// sample of importance ct_importance, which is composited with surfaces
/// and with the samples of the ultrasound as predicate_spec.hpp and predicate_scene.hpp say. With
/// equal importances that is plain compositing of everything.
///
/// Other projections. The greatest, least or (by length) mean value at the middles of all cells
/// between entry and exit, as grey = clamp((v - level) / width + 1/2), lies under the surfaces,
/// which are composited in their order; rays past the volume see the background.
///
/// The reference ignores opaque_at, which may only cost error, and skip_empty_bricks, which may
/// not.
namespace nav::render::spec {}
