// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPainter>
#include <vector>

#include "app/views/slice_view.hpp"
#include "render/features/scribbles.hpp"

namespace nav::app {

/// Brush with which the user paints scribbles on slices.
struct Brush {
  render::features::Paint paint = render::features::Paint::kShow;
  double radius_mm = 1;  ///< (0, 1000].
};

/// A stroke that begins on a slice at a pixel of its image. It is as thick as a voxel.
render::features::Stroke stroke_on(const SliceGeometry& slice, const Brush& brush,
                                   const Eigen::Vector2d& pixel);

/// Draws the strokes that were painted on this slice: green to show, red to hide. Later strokes
/// replace what lies under them, as they do in render::features::ScribbleMask. ratio: device pixels
/// of a pixel of the screen. grid: of the volume.
void draw_strokes(QPainter& painter, const SliceGeometry& slice, const VoxelGrid& grid,
                  const std::vector<render::features::Stroke>& strokes, double ratio);

}  // namespace nav::app
