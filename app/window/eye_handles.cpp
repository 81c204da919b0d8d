// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/eye_handles.hpp"

#include <Eigen/Geometry>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/window/slice_control.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kHandleText = 14;

/// Radius of the ring, logical pixels.
double ring_radius(const QSize& size) { return 0.36 * std::min(size.width(), size.height()); }

/// Angle by which a point turns about the middle, clockwise in an image whose y points down, rad.
double turned_rad(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                  const Eigen::Vector2d& middle) {
  const Eigen::Vector2d a = from - middle;
  const Eigen::Vector2d b = to - middle;
  return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
}

Eigen::Vector2d middle_of(const QImage& image) {
  return {0.5 * image.width(), 0.5 * image.height()};
}

}  // namespace

std::optional<EyeMovement> eye_movement(ViewId id, const ViewImage& view_image,
                                        const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                        bool turns) {
  const auto start = ct_point_at(id, view_image, from);
  const auto end = ct_point_at(id, view_image, to);
  if (!start || !end) return std::nullopt;
  const double sign = slice_of(id) ? -1 : 1;
  EyeMovement movement;
  if (!turns) {
    movement.shift_mm = sign * (end->mm - start->mm);
    return movement;
  }
  const Eigen::Vector2d middle = middle_of(view_image.image);
  const Eigen::Vector3d centre = ct_point_at(id, view_image, middle)->mm;
  const Eigen::Vector3d right =
      ct_point_at(id, view_image, middle + Eigen::Vector2d::UnitX())->mm - centre;
  const Eigen::Vector3d down =
      ct_point_at(id, view_image, middle + Eigen::Vector2d::UnitY())->mm - centre;
  movement.turn_rad = sign * turned_rad(from, to, middle) * right.cross(down).normalized();
  movement.about = {centre};
  return movement;
}

std::optional<EyeMovement> eye_movement_3d(const ViewImage& view_image, const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& to, bool turns) {
  if (!view_image.moment) return std::nullopt;
  const session::Epoch& epoch = view_image.moment->epoch;
  if (!epoch.frame || !epoch.ct_from_image || epoch.plane.state > SafetyState::kDegraded) {
    return std::nullopt;
  }
  const render::Camera& camera = view_image.camera;
  const Eigen::Vector3d sight = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
  const Eigen::Vector3d right = sight.cross(camera.up_ct.v).normalized();
  const Eigen::Vector3d down = sight.cross(right);
  EyeMovement movement;
  if (turns) {
    // The plane turns with the mouse, so the CT turns against it.
    movement.turn_rad = -turned_rad(from, to, middle_of(view_image.image)) * sight;
    movement.about = camera.look_at_ct;
    return movement;
  }
  const auto [least, most] = box_mm(epoch.frame->frame);
  const Eigen::Vector2d centre_mm = 0.5 * (least + most);
  const Point<frames::Ct> centre =
      *epoch.ct_from_image * Point<frames::Image>{{centre_mm.x(), centre_mm.y(), 0}};
  const double distance_mm = (centre.mm - camera.eye_ct.mm).dot(sight);
  const double height_mm = camera.orthographic
                               ? camera.orthographic_height_mm
                               : 2 * distance_mm * std::tan(0.5 * camera.vertical_fov_rad);
  if (!(height_mm > 0)) return std::nullopt;
  const Eigen::Vector2d way_mm = height_mm / view_image.image.height() * (to - from);
  movement.shift_mm = -(way_mm.x() * right + way_mm.y() * down);
  return movement;
}

bool EyeHandles::set_on(bool on) {
  if (on == on_) return false;
  on_ = on;
  end();
  return true;
}

void EyeHandles::begin(const QPointF& at, const QSize& size) {
  const QPointF from_middle = at - QRectF(QPointF(), size).center();
  drag_ =
      std::hypot(from_middle.x(), from_middle.y()) < ring_radius(size) ? Drag::kShift : Drag::kTurn;
  if (dragged) dragged(true);
}

bool EyeHandles::end() {
  if (std::exchange(drag_, Drag::kNone) == Drag::kNone) return false;
  if (dragged) dragged(false);
  return true;
}

/// In the colour of what the user handles.
void EyeHandles::paint(QPainter& painter, const QSize& size, const QString& also) {
  const QPointF middle = QRectF(QPointF(), size).center();
  const double radius = ring_radius(size);
  const QColor colour = QColor::fromRgb(theme::kWindowAccent);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setBrush(Qt::NoBrush);
  painter.setPen(QPen(colour, 2, Qt::DashLine));
  painter.drawEllipse(middle, radius, radius);
  painter.setPen(QPen(colour, 2));
  constexpr double kArm = 14;
  constexpr double kHead = 5;
  for (const QPointF& way : {QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)}) {
    const QPointF end = middle + kArm * way;
    const QPointF aside(way.y(), way.x());
    painter.drawLine(middle, end);
    painter.drawLine(end, end - kHead * way + kHead * aside);
    painter.drawLine(end, end - kHead * way - kHead * aside);
  }
  // Below the arrows: other words stand at the edges.
  double y = middle.y() + kArm + 6;
  for (const QString& words : {QStringLiteral("BY EYE: inside shift, outside turn"), also}) {
    if (words.isEmpty()) continue;
    const QFont font = theme::fitting_font(words, kHandleText, size.width() - 40, true);
    const QFontMetricsF metrics(font);
    theme::draw_tag(painter, middle.x() - metrics.horizontalAdvance(words) / 2 - 6, y, words, font,
                    colour);
    y += metrics.height() + 6;
  }
}

}  // namespace nav::app
