// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/brush.hpp"

#include <QImage>
#include <algorithm>
#include <cmath>

namespace nav::app {
namespace {

using render::features::Paint;
using render::features::Stroke;

/// Part of a stroke's colour; the anatomy below stays visible.
constexpr int kPaintAlpha = 110;
constexpr double kParallel = 0.999;

/// Half of the distance between the slices of a grid along a direction, mm.
double half_voxel_mm(const VoxelGrid& grid, const Eigen::Vector3d& normal) {
  return 0.5 * (grid.directions.transpose() * normal).cwiseAbs().dot(grid.spacing_mm);
}

bool lies_on(const Stroke& stroke, const SliceGeometry& slice, const VoxelGrid& grid) {
  const Eigen::Vector3d normal = slice.plane.right.v.cross(slice.plane.down.v).normalized();
  if (std::abs(stroke.plane_normal.v.normalized().dot(normal)) < kParallel) return false;
  const double thick =
      stroke.half_thickness_mm > 0 ? stroke.half_thickness_mm : half_voxel_mm(grid, normal);
  return std::abs(slice.pixel_of(stroke.points.front()).z()) <= thick;
}

}  // namespace

Stroke stroke_on(const SliceGeometry& slice, const Brush& brush, const Eigen::Vector2d& pixel) {
  return {.points = {slice.point_at(pixel)},
          .plane_normal = {slice.plane.right.v.cross(slice.plane.down.v).normalized()},
          .radius_mm = brush.radius_mm,
          .paint = brush.paint};
}

void draw_strokes(QPainter& painter, const SliceGeometry& slice, const VoxelGrid& grid,
                  const std::vector<Stroke>& strokes, double ratio) {
  const bool any = std::ranges::any_of(
      strokes, [&](const Stroke& stroke) { return lies_on(stroke, slice, grid); });
  if (!any) return;
  QImage layer(slice.size.width, slice.size.height, QImage::Format_ARGB32_Premultiplied);
  layer.fill(Qt::transparent);
  QPainter on_layer(&layer);
  on_layer.setRenderHint(QPainter::Antialiasing);
  on_layer.setCompositionMode(QPainter::CompositionMode_Source);
  for (const Stroke& stroke : strokes) {
    if (!lies_on(stroke, slice, grid)) continue;
    const QColor colour = stroke.paint == Paint::kShow   ? QColor(0x50, 0xf0, 0x70, kPaintAlpha)
                          : stroke.paint == Paint::kHide ? QColor(0xff, 0x50, 0x50, kPaintAlpha)
                                                         : QColor(0, 0, 0, 0);
    const double width = std::max(1.0, 2 * stroke.radius_mm / slice.mm_per_px);
    on_layer.setPen(QPen(colour, width, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
    QPolygonF line;
    for (const auto& point : stroke.points) {
      const Eigen::Vector3d p = slice.pixel_of(point);
      line << QPointF(p.x() + 0.5, p.y() + 0.5);
    }
    if (line.size() == 1) {
      on_layer.drawPoint(line.front());
    } else {
      on_layer.drawPolyline(line);
    }
  }
  on_layer.end();
  layer.setDevicePixelRatio(ratio);
  painter.drawImage(QPointF(0, 0), layer);
}

}  // namespace nav::app
