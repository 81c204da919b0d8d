// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/window/brush.hpp"
#include "app/window/eye_handles.hpp"
#include "app/window/slice_control.hpp"
#include "app/window/view_widget.hpp"
#include "session/critical_structures.hpp"

namespace nav::app {

/// Colour of an orthogonal slice's name and frame, as in 3D Slicer; absent for other views. No
/// state has one of them.
std::optional<QRgb> slice_colour(ViewId id);

/// A flat view: left button sets the cursor, middle button moves, right button changes window and
/// level, wheel goes through the slices, Ctrl and wheel zoom, a double click enlarges the view.
/// Shows the cursor, and for slices letters, scale, window and position.
class FlatWidget : public ViewWidget {
 public:
  FlatWidget(ViewId id, const QString& name, const QString& title, QWidget* parent);

  /// Called for what the user does, with the image that the user sees.
  std::function<void(ViewId, const SliceInput&, const ViewImage&)> moved;
  /// Called by a double click.
  std::function<void()> enlarge;
  [[nodiscard]] ViewId id() const { return id_; }

  /// Asked for a click of the left button, with the point of the CT. True: it is taken.
  std::function<bool(const Point<frames::Ct>&)> picked;
  /// Critical structures that are spheres, drawn where they meet a slice of the CT.
  void set_structures(std::vector<session::CriticalStructure::Sphere> structures);
  /// Shows the handles, or not.
  void set_by_eye(bool on);
  EyeHandles& handles() { return handles_; }
  /// A brush for slices of 3D ultrasound: the left button paints in place of setting the cursor.
  /// Absent: none.
  void set_brush(const std::optional<Brush>& brush);
  /// Strokes that were painted, on whichever slice.
  void set_strokes(std::vector<render::features::Stroke> strokes);
  /// Called when a stroke has ended.
  std::function<void(render::features::Stroke)> stroked;

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void paint_marks(QPainter& painter, const ViewImage& view_image) override;

 private:
  void send(const SliceInput& input);
  [[nodiscard]] Eigen::Vector2d device_pixel(const QPointF& at) const;
  void paint_cursor(QPainter& painter, const ViewImage& view_image);
  void paint_slice_words(QPainter& painter, const ViewImage& view_image);
  void paint_rings(QPainter& painter, const ViewImage& view_image);
  void paint_structures(QPainter& painter, const ViewImage& view_image);
  void paint_strokes(QPainter& painter, const ViewImage& view_image);
  /// True: the left button places the CT here.
  [[nodiscard]] bool places() const;
  /// True: the left button paints here.
  [[nodiscard]] bool paints() const;

  /// A stroke in the making, on the slice on which it began.
  struct Painting {
    SliceGeometry slice;
    render::features::Stroke stroke;
  };
  EyeHandles handles_;
  std::optional<Brush> brush_;
  std::optional<Painting> painting_;
  std::vector<render::features::Stroke> strokes_;
  std::vector<session::CriticalStructure::Sphere> structures_;

  ViewId id_;
  QPointF last_;
  Qt::MouseButton button_ = Qt::NoButton;  ///< The one that began the drag; others do nothing.
  double notches_ = 0;                     ///< Parts of a notch of the wheel.
};

/// The live ultrasound: depth scale in cm with ticks every 5 mm, and a dot at the marked side.
class UltrasoundWidget final : public FlatWidget {
 public:
  using FlatWidget::FlatWidget;

  /// Words about the CT that is laid over the image; empty: none is.
  void set_overlay_words(const QString& words) {
    overlay_ = words;
    update();
  }

 private:
  void paint_marks(QPainter& painter, const ViewImage& view_image) override;

  QString overlay_;
};

}  // namespace nav::app
