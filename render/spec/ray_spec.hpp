// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/spec/ray_spec_cutaway.hpp"
#include "render/spec/ray_spec_surfaces.hpp"
#include "render/spec/ray_spec_volume.hpp"

/// The one specification of a rendered image. The reference engine runs it in double precision. The
/// CPU engine prepares its rays and surfaces with it. The GLSL of shaders/ mirrors it line by line.
///
/// Coordinates. "Local mm" are CT axes (LPS, mm) minus grid.origin_mm. The subtraction comes first
/// and is done in double, so that a CT far from the world's origin loses no digits. "Index" is the
/// continuous voxel index: index = (directionsᵀ · local) ∘ 1/spacing.
///
/// Ray. The ray of pixel (x, y), row 0 at the top, runs through the pixel's centre. t is the
/// distance from the ray's origin in mm, t >= 0. Perspective: the origin is the eye. Orthographic:
/// the origin lies on the plane through the eye.
///
/// Box. The volume fills the box of its voxel centres, [0, n - 1] per axis. Along an axis with a
/// single voxel this box would have no thickness. There the volume fills half a voxel on either
/// side, [-1/2, 1/2], and its value is constant along that axis.
///
/// Cells. h = quality.step_voxels · min(spacing). Cell k covers t in [k h, (k + 1) h). This lattice
/// is global: it holds for every ray and every scene. With quality.jitter, cell k covers
/// [(k + u) h, (k + 1 + u) h) with u = jitter_of(pixel). Values are trilinear HU, with the index
/// clamped to [0, n - 1] per axis.
///   Pre-integrated: the values of a cell run linearly from v0 at its begin to v1 at its end.
///   Post-classified: a cell has one value, the value at its middle.
/// Events of the ray (entry, surfaces, exit) cut a cell exactly to a part [a, b]. Its values va and
/// vb lie on the line from v0 to v1, and its length is (b - a) h.
///
/// Classification. TransferTable gives extinction tau and colour:
///   pre-integrated: mean(va, vb, bow); post-classified: at(v).
/// The bow of a whole cell between lattice points k and k + 1 comes from the parabola through the
/// values at k - 1, k and k + 1. It is the mean of the parabola over the cell minus the mean of the
/// line: bow_of(). The bow is 0 for a cell that is cut. It is also 0 unless k - 1 lies behind the
/// lattice point at or in front of the entry into the box.
/// Without the bow, all errors of a ray have one sign, and noise is drawn too faint.
/// A transfer function with gradient windows is always post-classified, with the gradient at the
/// middle.
///
/// Cutaway (ray_spec_cutaway.hpp). A part that begins in front of T2 has the visibilities
/// V_a = visibility(I(va), Omega(a)) and V_b at its ends. If they differ by at most kFadeVaries,
/// tau is faded(tau, (V_a + V_b) / 2), and everything else is as without a cutaway. Otherwise the
/// cell is the mean of kFadeSteps equidistant midpoints of the part. Midpoint j has the value v_j
/// on the part's line and Omega at its own t; tau_j = faded(tau, visibility(I(v_j), Omega_j)). The
/// colour is weighted by tau_j.
///
/// Importance of a cell. It is needed only when shading.emphasis > 0. It is the mean of I(va) and
/// I(vb) if they differ by at most kFadeVaries. Otherwise it is the mean of I over the kFadeSteps
/// midpoints, weighted by tau, or 1 when all of these weights are 0. If a cell is a mean of
/// midpoints because its visibility varies, its importance is the mean of I weighted by tau_j,
/// whatever I is.
///
/// Opacity of a cell: alpha = -expm1(-tau · length_mm).
///
/// Colour. If shading.enabled, shade_sample() shades the colour with the gradient at the cell's
/// middle and the share that the importance gives. A share of 0 needs no gradient. Pre-integrated:
/// the colour is the mean over shades_of() positions of the cell, each shaded this way.
///
/// Gradient. Central difference with one voxel on either side along each index axis, positions
/// clamped to [0, n - 1], divided by 2 · spacing_mm, rotated by directions: HU per mm along the CT
/// axes. Its values are those of scene.gradient_source, if there is one, otherwise of the CT.
///
/// Compositing, front to back, premultiplied: C += (1 - A) · alpha · rgb; A += (1 - A) · alpha.
/// Surfaces are samples with their own alpha at their exact t, sorted by t (for equal t: plane,
/// needle, spheres in order, lines in order). The first surface with alpha 1 ends the ray. A
/// surface is drawn if t > 0, inside the volume or not. Early termination: the ray ends once
/// A >= quality.opaque_at (< 1), and the pixel is C / A. Then no channel is wrong by more than
/// 1 - A, and no channel is always too dark. Otherwise the pixel is C + (1 - A) · background. The
/// pixel's alpha is 1.
///
/// Two volumes. With scene.ultrasound, the CT and the ultrasound each have their own lattice of
/// cells with their own h; H is the greater h. A ray that runs through both boxes is cut at
/// t = m H. In slab m the part of the CT is composited in front of the part of the ultrasound if m
/// is even, and behind it if m is odd, so that the depth order is correct to the second order of H.
/// The CT's part of a slab is first composited alone, as above. The result is one sample of
/// importance ct_importance. It is composited with the surfaces and the samples of the ultrasound
/// as predicate_spec.hpp and predicate_scene.hpp say. With equal importances this is plain
/// compositing of everything.
///
/// Other projections. The greatest, least or mean (by length) value v at the middles of all cells
/// between entry and exit gives grey = clamp((v - level) / width + 1/2). It lies under the
/// surfaces, which are composited in their order. Rays that miss the volume show the background.
///
/// The reference ignores opaque_at, which may only cost accuracy, and skip_empty_bricks, which may
/// not cost any.
namespace nav::render::spec {}
