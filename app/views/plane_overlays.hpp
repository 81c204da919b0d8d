// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/views/panels.hpp"
#include "app/views/plane_view.hpp"
#include "render/canvas.hpp"

namespace nav::app {

/// Colour of the needle and of the probe's marked side, in every view.
inline constexpr Rgba8 kNeedleColour = render::rgb8(0x8fd3ff);

/// Corner of an ultrasound image at the probe's marked side, at the transducer face.
Point<frames::Image> marked_corner(const UltrasoundImage& frame);

/// Draws depth marks every 10 mm at the right edge, with numbers in mm every 50 or 20 mm, and a dot
/// at the probe's marked side. size: of the numbers, pixels.
void draw_depth_marks(render::Canvas& canvas, const PlaneView& view, const UltrasoundImage& frame,
                      int size);

/// Draws the needle, the planned path and the target where they meet the ultrasound plane. Draws
/// nothing without a placed image, and no needle that is stale or lost.
void draw_in_plane(render::Canvas& canvas, const PlaneView& view, const PanelContext& context);
/// Draws them where they meet another plane of the CT, whose position ct_from_image tells.
void draw_in_plane(render::Canvas& canvas, const PlaneView& view,
                   const Transform<frames::Ct, frames::Image>& ct_from_image,
                   const PanelContext& context);

/// Colour of the planned path, as in the 3D view.
inline constexpr Rgba8 kPathColour = render::rgb8(0x33b3ff);

/// Draws the planned path projected onto a plane of the CT: dashed, with a dot at the entry. Parts
/// that lie in the plane are drawn by draw_in_plane().
void draw_path_onto(render::Canvas& canvas, const PlaneView& view,
                    const Transform<frames::Ct, frames::Image>& ct_from_image,
                    const NeedlePlan& plan);

}  // namespace nav::app
