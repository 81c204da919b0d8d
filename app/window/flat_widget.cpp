// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/flat_widget.hpp"

#include <QMouseEvent>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/views/bulls_eye.hpp"
#include "app/views/overlay.hpp"
#include "app/views/plane_overlays.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kMarkText = 14;
constexpr double kMarkMargin = 8;
constexpr double kWheelNotch = 120;
/// A cursor farther from an oblique view is not drawn in it, mm.
constexpr double kCursorReachMm = 2;

/// The largest length of 1, 2 or 5 times a power of ten that is at most as long, mm.
double round_length(double most_mm) {
  const double decade = std::pow(10.0, std::floor(std::log10(most_mm)));
  double length = decade;
  for (const double step : {2.0, 5.0}) {
    if (step * decade <= most_mm) length = step * decade;
  }
  return length;
}

}  // namespace

std::optional<QRgb> slice_colour(ViewId id) {
  switch (id) {
    case ViewId::kAxial:
      return 0xfff34a33;
    case ViewId::kCoronal:
      return 0xff6eb04b;
    case ViewId::kSagittal:
      return 0xffedd54c;
    default:
      return std::nullopt;
  }
}

FlatWidget::FlatWidget(ViewId id, const QString& name, const QString& title, QWidget* parent)
    : ViewWidget(name, title, parent), id_(id) {
  if (const auto colour = slice_colour(id)) set_own_colour(*colour);
}

Eigen::Vector2d FlatWidget::device_pixel(const QPointF& at) const {
  const double ratio = devicePixelRatioF();
  return {at.x() * ratio - 0.5, at.y() * ratio - 0.5};
}

void FlatWidget::send(const SliceInput& input) {
  // Under a cover the user sees no image that could be pointed at.
  if (moved && view_image() && !judgement().covered) moved(id_, input, *view_image());
}

void FlatWidget::mousePressEvent(QMouseEvent* event) {
  if (button_ != Qt::NoButton) return;
  button_ = event->button();
  last_ = event->position();
  if (button_ == Qt::LeftButton && picked && has_mode() && view_image() && !judgement().covered) {
    const auto point = ct_point_at(id_, *view_image(), device_pixel(last_));
    if (point && picked(*point)) {
      button_ = Qt::NoButton;
      return;
    }
  }
  if (button_ == Qt::LeftButton && places()) {
    handles_.begin(last_, size());
  } else if (button_ == Qt::LeftButton && paints()) {
    const SliceGeometry& slice = *view_image()->slice;
    painting_ = Painting{slice, stroke_on(slice, *brush_, device_pixel(last_))};
    update();
  } else if (button_ == Qt::LeftButton) {
    send({.kind = SliceInput::Kind::kCursor, .at = device_pixel(last_)});
  }
}

void FlatWidget::set_by_eye(bool on) {
  if (handles_.set_on(on)) update();
}

bool FlatWidget::places() const {
  return handles_.on() && view_image() && !judgement().covered &&
         ct_point_at(id_, *view_image(), {0, 0}).has_value() && id_ != ViewId::kBullsEye &&
         !view_image()->of_ultrasound;
}

bool FlatWidget::paints() const {
  return brush_ && is_orthogonal(id_) && view_image() && view_image()->slice &&
         view_image()->of_ultrasound && !judgement().covered;
}

void FlatWidget::set_brush(const std::optional<Brush>& brush) {
  brush_ = brush;
  painting_.reset();
  if (is_orthogonal(id_)) setCursor(brush ? Qt::CrossCursor : Qt::ArrowCursor);
  update();
}

void FlatWidget::set_strokes(std::vector<render::features::Stroke> strokes) {
  strokes_ = std::move(strokes);
  update();
}

void FlatWidget::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != button_) return;
  button_ = Qt::NoButton;
  if (handles_.end()) return;
  if (!painting_) return;
  render::features::Stroke stroke = std::move(painting_->stroke);
  painting_.reset();
  if (stroked) stroked(std::move(stroke));
  update();
}

void FlatWidget::mouseDoubleClickEvent(QMouseEvent* event) {
  if ((brush_ && is_orthogonal(id_)) || places()) return;
  if (event->button() == Qt::LeftButton && enlarge) enlarge();
}

void FlatWidget::mouseMoveEvent(QMouseEvent* event) {
  if (button_ == Qt::NoButton) return;
  const QPointF way = event->position() - last_;
  const QPointF before = std::exchange(last_, event->position());
  if (handles_.drag() != EyeHandles::Drag::kNone) {
    if (!places() || !handles_.moved) return;
    const auto movement =
        eye_movement(id_, *view_image(), device_pixel(before), device_pixel(last_),
                     handles_.drag() == EyeHandles::Drag::kTurn);
    if (movement) handles_.moved(*movement);
    return;
  }
  constexpr std::size_t kMostPoints = 10000;
  if (painting_) {
    auto& points = painting_->stroke.points;
    if (points.size() < kMostPoints) {
      points.push_back(painting_->slice.point_at(device_pixel(last_)));
    }
    update();
  } else if (button_ == Qt::LeftButton) {
    send({.kind = SliceInput::Kind::kCursor, .at = device_pixel(last_)});
  } else if (button_ == Qt::MiddleButton) {
    const double ratio = devicePixelRatioF();
    send({.kind = SliceInput::Kind::kPan, .drag = {way.x() * ratio, way.y() * ratio}});
  } else if (button_ == Qt::RightButton) {
    const double size = std::max(1, height());
    send({.kind = SliceInput::Kind::kWindow, .drag = {way.x() / size, -way.y() / size}});
  }
}

void FlatWidget::wheelEvent(QWheelEvent* event) {
  event->accept();
  const double notches = std::clamp(event->angleDelta().y() / kWheelNotch, -1000.0, 1000.0);
  if (event->modifiers().testFlag(Qt::ControlModifier)) {
    constexpr double kZoomOfNotch = 1.15;
    send({.kind = SliceInput::Kind::kZoom,
          .at = device_pixel(event->position()),
          .amount = std::pow(kZoomOfNotch, std::clamp(notches, -20.0, 20.0))});
    return;
  }
  // A touch pad sends parts of a notch.
  notches_ += notches;
  const double whole = std::trunc(notches_);
  notches_ -= whole;
  if (whole != 0) send({.kind = SliceInput::Kind::kStep, .amount = whole});
}

void FlatWidget::set_structures(std::vector<session::CriticalStructure::Sphere> structures) {
  structures_ = std::move(structures);
  update();
}

/// Violet, which is the colour of no state and of no slice.
void FlatWidget::paint_structures(QPainter& painter, const ViewImage& view_image) {
  if (!view_image.slice || view_image.of_ultrasound || id_ == ViewId::kBullsEye) return;
  const double ratio = view_image.image.devicePixelRatio();
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setBrush(Qt::NoBrush);
  painter.setPen(QPen(QColor::fromRgb(theme::kWindowStructure), 2));
  for (const auto& sphere : structures_) {
    const Eigen::Vector3d at = view_image.slice->pixel_of(sphere.centre_ct);
    const double squared = sphere.radius_mm * sphere.radius_mm - at.z() * at.z();
    if (squared <= 0) continue;
    const double radius = std::sqrt(squared) / view_image.slice->mm_per_px / ratio;
    painter.drawEllipse(QPointF(at.x() / ratio, at.y() / ratio), radius, radius);
  }
}

void FlatWidget::paint_marks(QPainter& painter, const ViewImage& view_image) {
  paint_structures(painter, view_image);
  paint_strokes(painter, view_image);
  paint_cursor(painter, view_image);
  if (places()) EyeHandles::paint(painter, size(), {});
  if (!view_image.slice) return;
  paint_slice_words(painter, view_image);
  if (id_ == ViewId::kBullsEye) paint_rings(painter, view_image);
}

void FlatWidget::paint_strokes(QPainter& painter, const ViewImage& view_image) {
  if (!is_orthogonal(id_) || !view_image.slice || !view_image.of_ultrasound) return;
  const auto& source = view_image.moment->predicates;
  if (!source) return;
  std::vector<render::features::Stroke> all = strokes_;
  if (painting_) all.push_back(painting_->stroke);
  draw_strokes(painter, *view_image.slice, source->volume.ultrasound->grid(), all,
               view_image.image.devicePixelRatio());
  using render::features::Paint;
  const QString mode = !brush_                         ? QString()
                       : brush_->paint == Paint::kShow ? QStringLiteral("PAINT: SHOW")
                       : brush_->paint == Paint::kHide ? QStringLiteral("PAINT: HIDE")
                                                       : QStringLiteral("PAINT: ERASE");
  const QString what = QStringLiteral("3D ultrasound");
  const QFont small = theme::font(kMarkText, true);
  const double line = QFontMetricsF(small).height() + 4;
  // Below the line of the title.
  theme::draw_tag(painter, kMarkMargin - 2, kMarkMargin + line + 4, mode.isEmpty() ? what : mode,
                  small, QColor::fromRgb(theme::kWindowAccent));
}

void FlatWidget::paint_cursor(QPainter& painter, const ViewImage& view_image) {
  const double ratio = view_image.image.devicePixelRatio();
  painter.setRenderHint(QPainter::Antialiasing, false);
  if (is_orthogonal(id_) && view_image.slice) {
    const Eigen::Vector3d at = view_image.slice->pixel_of(view_image.cursor) / ratio;
    // Each line has the colour of the slice that it stands for.
    const bool axial = id_ == ViewId::kAxial;
    const QRgb across = *slice_colour(axial ? ViewId::kCoronal : ViewId::kAxial);
    const QRgb along =
        *slice_colour(id_ == ViewId::kSagittal ? ViewId::kCoronal : ViewId::kSagittal);
    constexpr double kGap = 8;
    painter.setPen(QPen(QColor::fromRgb(across), 1));
    painter.drawLine(QPointF(0, at.y()), QPointF(at.x() - kGap, at.y()));
    painter.drawLine(QPointF(at.x() + kGap, at.y()), QPointF(width(), at.y()));
    painter.setPen(QPen(QColor::fromRgb(along), 1));
    painter.drawLine(QPointF(at.x(), 0), QPointF(at.x(), at.y() - kGap));
    painter.drawLine(QPointF(at.x(), at.y() + kGap), QPointF(at.x(), height()));
    return;
  }
  std::optional<QPointF> at;
  if (slice_of(id_) && view_image.slice) {
    const Eigen::Vector3d p = view_image.slice->pixel_of(view_image.cursor);
    if (std::abs(p.z()) <= kCursorReachMm) at = QPointF(p.x() / ratio, p.y() / ratio);
  } else if (view_image.plane && view_image.moment->epoch.ct_from_image &&
             view_image.moment->epoch.plane.state <= SafetyState::kDegraded) {
    const Eigen::Vector3d p =
        (view_image.moment->epoch.ct_from_image->inverse() * view_image.cursor).mm;
    const Eigen::Vector2d pixel = view_image.plane->pixel_of(p.head<2>()) / ratio;
    if (std::abs(p.z()) <= kCursorReachMm) at = QPointF(pixel.x(), pixel.y());
  }
  if (!at) return;
  painter.setPen(QPen(Qt::white, 1));
  for (const QPointF& arm : {QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)}) {
    painter.drawLine(*at + 4 * arm, *at + 12 * arm);
  }
}

void FlatWidget::paint_slice_words(QPainter& painter, const ViewImage& view_image) {
  const QColor text = QColor::fromRgb(theme::kWindowText);
  const QFont small = theme::font(kMarkText);
  const QFont large = theme::font(18, true);
  const double line = QFontMetricsF(small).height() + 4;
  const auto letter = [&](double x, double y, const std::string& words) {
    const QString shown = theme::plain(words);
    const QFontMetricsF metrics(large);
    theme::draw_tag(painter, x - metrics.horizontalAdvance(shown) / 2 - 6,
                    y - metrics.height() / 2 - 2, shown, large, text);
  };
  const render::SliceLabels letters = render::labels_of(view_image.slice->plane);
  letter(22, height() / 2.0, letters.left);
  letter(width() - 22, height() / 2.0, letters.right);
  // Below the line of the state.
  letter(width() / 2.0, kMarkMargin + line + 20, letters.top);
  letter(width() / 2.0, height() - 22, letters.bottom);

  double y = height() - kMarkMargin - line;
  const double mm_per_pixel = view_image.slice->mm_per_px * view_image.image.devicePixelRatio();
  const double most_mm = width() / 4.0 * mm_per_pixel;
  if (most_mm > 1e-3 && width() > 120) {
    const double length_mm = round_length(most_mm);
    const double length = length_mm / mm_per_pixel;
    const double x = kMarkMargin + 6;
    const double base = y + line / 2;
    for (const auto& [colour, thick] : {std::pair(QColor(Qt::black), 4.0), {text, 2.0}}) {
      painter.setPen(QPen(colour, thick));
      painter.drawLine(QPointF(x, base), QPointF(x + length, base));
      painter.drawLine(QPointF(x, base - 5), QPointF(x, base + 5));
      painter.drawLine(QPointF(x + length, base - 5), QPointF(x + length, base + 5));
    }
    theme::draw_tag(painter, x + length + 4, y, QStringLiteral("%1 mm").arg(length_mm), small,
                    text);
    y -= line + 2;
  }
  if (id_ == ViewId::kBullsEye || height() < 160) return;
  theme::draw_tag(painter, kMarkMargin, y,
                  theme::plain(words_of_window(std::round(view_image.window.level),
                                               std::round(view_image.window.width))),
                  small, text);
  if (!is_orthogonal(id_) || height() < 200) return;
  theme::draw_tag(painter, kMarkMargin, y - line - 2,
                  theme::plain(position_words(view_image.cursor.mm)), small, text);
}

void FlatWidget::paint_rings(QPainter& painter, const ViewImage& view_image) {
  const double mm_per_pixel = view_image.slice->mm_per_px * view_image.image.devicePixelRatio();
  const QFont small = theme::font(kMarkText);
  const QFontMetricsF metrics(small);
  double last = 0;
  for (const double ring_mm : kBullsEyeRingsMm) {
    const double radius = ring_mm / mm_per_pixel;
    const double x = width() / 2.0 + radius;
    const QString words = QStringLiteral("%1").arg(ring_mm);
    const double needed = metrics.horizontalAdvance(words) + 16;
    if (radius - last < needed || x + needed > width() - 44) continue;
    last = radius;
    theme::draw_tag(painter, x + 2, height() / 2.0 + 2, words, small,
                    QColor::fromRgb(theme::kWindowFaint));
  }
}

void UltrasoundWidget::paint_marks(QPainter& painter, const ViewImage& view_image) {
  FlatWidget::paint_marks(painter, view_image);
  if (!overlay_.isEmpty()) {
    const QFont small = theme::font(kMarkText, true);
    const double line = QFontMetricsF(small).height() + 4;
    theme::draw_tag(painter, kMarkMargin - 2, height() - kMarkMargin - line, overlay_, small,
                    QColor::fromRgb(theme::kWindowAccent));
  }
  if (!view_image.plane || !view_image.moment->epoch.frame) return;
  const UltrasoundImage& frame = view_image.moment->epoch.frame->frame;
  const double ratio = view_image.image.devicePixelRatio();
  const PlaneView& plane = *view_image.plane;
  const auto at = [&](const Eigen::Vector2d& mm) -> QPointF {
    const Eigen::Vector2d p = plane.pixel_of(mm) / ratio;
    return {p.x(), p.y()};
  };
  const double deepest = box_mm(frame).second.y();
  painter.setFont(theme::font(13));
  const QFontMetricsF metrics(painter.font());
  for (int depth = 0; depth <= deepest && depth <= 1000; depth += 5) {
    const double y = at({0, depth}).y();
    const bool whole = depth % 10 == 0;
    painter.setPen(QColor::fromRgb(theme::kWindowFaint));
    const double edge = width() - 4;
    painter.drawLine(QPointF(edge - (whole ? 10 : 5), y), QPointF(edge, y));
    const double step = at({0, 10}).y() - at({0, 0}).y();
    const int every = step >= metrics.height() + 2 ? 10 : 50;
    if (depth % every != 0 || depth == 0) continue;
    // The first number has the unit.
    const QString number =
        QString::number(depth / 10) + (depth == every ? QStringLiteral(" cm") : QString());
    const double x = edge - 14 - metrics.horizontalAdvance(number);
    painter.drawText(QPointF(x, y + metrics.ascent() / 2 - 1), number);
  }
  const QPointF corner = at(marked_corner(frame).mm.head<2>());
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(Qt::NoPen);
  painter.setBrush(QColor::fromRgb(theme::kWindowAccent));
  painter.drawEllipse(QPointF(std::clamp(corner.x(), 12.0, width() - 44.0),
                              std::clamp(corner.y(), 40.0, height() - 12.0)),
                      6, 6);
}

}  // namespace nav::app
