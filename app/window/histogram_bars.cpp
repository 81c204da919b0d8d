// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/histogram_bars.hpp"

#include <QHelpEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "app/predicates/predicate_legend.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kBarText = 12;
constexpr double kAxisWidth = 30;
constexpr double kHeaderHeight = 20;
constexpr double kNamesHeight = 18;
/// A shorter way of the mouse is a click.
constexpr double kLeastDragPixels = 2;

QColor fill_of(const render::PredicateHistogram::Bar& bar) {
  const Rgba8 colour = bar_colour(bar);
  return QColor(colour.r, colour.g, colour.b);
}

QString value_text(double importance) { return QString::number(importance, 'f', 3); }

}  // namespace

HistogramBars::HistogramBars(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("histogram"));
  setAccessibleName(QStringLiteral("Predicate histogram"));
  setMinimumSize(160, 100);
  setFocusPolicy(Qt::StrongFocus);
}

void HistogramBars::show_model(const render::PredicateModel& model,
                               std::optional<std::size_t> selected) {
  model_ = model;
  selected_ = selected;
  if (drag_ && drag_->bar >= size()) drag_.reset();
  update();
}

std::optional<std::size_t> HistogramBars::find(const QString& name) const {
  for (std::size_t i = 0; i < size(); ++i) {
    QString own = theme::plain(model_.entries[i].name);
    if (own == name || own.replace(QLatin1Char(' '), QLatin1Char('-')) == name) return i;
  }
  return std::nullopt;
}

double HistogramBars::importance_of(std::size_t bar) const {
  return model_.histogram.bars().at(bar).importance;
}

QRectF HistogramBars::plot() const {
  return QRectF(rect()).adjusted(kAxisWidth, kHeaderHeight, -6, -kNamesHeight);
}

QRectF HistogramBars::slot_of(std::size_t bar) const {
  const QRectF area = plot();
  const double width = area.width() / static_cast<double>(std::max<std::size_t>(1, size()));
  return {area.left() + width * static_cast<double>(bar), area.top(), width, area.height()};
}

QPointF HistogramBars::point_of(std::size_t bar, double importance) const {
  const QRectF slot = slot_of(bar);
  return {slot.center().x(), slot.bottom() - importance * slot.height()};
}

std::optional<std::size_t> HistogramBars::bar_at(const QPointF& at) const {
  for (std::size_t i = 0; i < size(); ++i) {
    const QRectF slot = slot_of(i);
    if (at.x() >= slot.left() && at.x() < slot.right()) return i;
  }
  return std::nullopt;
}

void HistogramBars::mousePressEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || drag_) return;
  const auto bar = bar_at(event->position());
  if (!bar) return;
  const std::size_t bars = size();
  if (picked) picked(*bar);
  // Choosing may have added a bar, which is then not dragged.
  if (size() != bars || *bar >= size()) return;
  drag_ = Drag{*bar, event->position().y(), importance_of(*bar)};
}

void HistogramBars::mouseMoveEvent(QMouseEvent* event) {
  if (!drag_) return;
  const double way = drag_->from_y - event->position().y();
  if (!drag_->moved && std::abs(way) < kLeastDragPixels) return;
  if (!std::exchange(drag_->moved, true) && drag_began) drag_began();
  const double height = std::max(1.0, plot().height());
  const Drag now = *drag_;
  if (dragged) dragged(now.bar, std::clamp(now.importance + way / height, 0.0, 1.0));
}

void HistogramBars::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || !drag_) return;
  const bool moved = drag_->moved;
  drag_.reset();
  if (moved && drag_ended) drag_ended();
  update();
}

void HistogramBars::keyPressEvent(QKeyEvent* event) {
  constexpr double kKeyStep = 0.02;
  const auto bars = static_cast<int>(size());
  if (!selected_ || bars == 0) return QWidget::keyPressEvent(event);
  const auto bar = static_cast<int>(*selected_);
  const auto pick = [&](int to) {
    if (picked) picked(static_cast<std::size_t>(std::clamp(to, 0, bars - 1)));
  };
  const auto raise = [&](double by) {
    const double to = std::clamp(importance_of(*selected_) + by, 0.0, 1.0);
    if (dragged) dragged(*selected_, to);
  };
  switch (event->key()) {
    case Qt::Key_Left:
      return pick(bar - 1);
    case Qt::Key_Right:
      return pick(bar + 1);
    case Qt::Key_Up:
      return raise(kKeyStep);
    case Qt::Key_Down:
      return raise(-kKeyStep);
    default:
      QWidget::keyPressEvent(event);
  }
}

bool HistogramBars::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QWidget::event(event);
  const auto* help = static_cast<const QHelpEvent*>(event);
  const auto bar = bar_at(help->pos());
  QToolTip::showText(help->globalPos(), bar ? theme::plain(model_.entries[*bar].name) +
                                                  QLatin1Char(' ') + value_text(importance_of(*bar))
                                            : QString());
  return true;
}

void HistogramBars::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  const QFont font = theme::font(kBarText);
  const QFontMetricsF metrics(font);
  painter.setFont(font);
  const QColor text = QColor::fromRgb(theme::kWindowText);
  const QColor faint = QColor::fromRgb(theme::kWindowFaint);
  const QRectF area = plot();
  for (const double mark : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double y = area.bottom() - mark * area.height();
    painter.setPen(QColor::fromRgb(theme::kWindowEdge));
    painter.drawLine(QPointF(area.left(), y), QPointF(area.right(), y));
    if (mark != 0 && mark != 0.5 && mark != 1) continue;
    const QString number = QString::number(mark, 'f', 1);
    painter.setPen(faint);
    painter.drawText(
        QPointF(area.left() - metrics.horizontalAdvance(number) - 5, y + metrics.ascent() / 2 - 1),
        number);
  }
  if (size() == 0) {
    painter.setPen(text);
    painter.drawText(area, Qt::AlignCenter, QStringLiteral("no predicate"));
  }
  bool names_fit = size() > 0;
  for (std::size_t i = 0; i < size(); ++i) {
    const double width = metrics.horizontalAdvance(theme::plain(model_.entries[i].name));
    names_fit = names_fit && width + 4 <= slot_of(i).width();
  }
  for (std::size_t i = 0; i < size(); ++i) {
    const auto& bar = model_.histogram.bars()[i];
    const QRectF slot = slot_of(i);
    const double gap = std::min(6.0, 0.12 * slot.width());
    const double top = point_of(i, bar.importance).y();
    const QRectF filled(slot.left() + gap, top, slot.width() - 2 * gap,
                        std::max(1.0, slot.bottom() - top));
    painter.fillRect(filled, fill_of(bar));
    if (selected_ == i) {
      painter.setPen(QPen(Qt::white, 2));
      painter.drawRect(filled.adjusted(-1, -1, 1, 1));
    }
    if (!names_fit) continue;
    painter.setPen(selected_ == i ? text : faint);
    painter.drawText(QRectF(slot.left(), slot.bottom(), slot.width(), kNamesHeight),
                     Qt::AlignCenter, theme::plain(model_.entries[i].name));
  }
  // The chosen bar, with its number.
  if (selected_ && *selected_ < size()) {
    const QString name = theme::plain(model_.entries[*selected_].name);
    painter.setFont(theme::font(kBarText + 1, true));
    painter.setPen(text);
    painter.drawText(QRectF(area.left(), 0, area.width(), kHeaderHeight),
                     Qt::AlignLeft | Qt::AlignVCenter,
                     QStringLiteral("%1   %2").arg(value_text(importance_of(*selected_)), name));
  }
  if (hasFocus()) {
    painter.setPen(QPen(Qt::white, 2));
    painter.setBrush(Qt::NoBrush);
    painter.drawRect(QRectF(rect()).adjusted(1, 1, -1, -1));
  }
}

}  // namespace nav::app
