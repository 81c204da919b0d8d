// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/transfer_graph.hpp"

#include <QMouseEvent>
#include <QPainter>
#include <QPainterPath>
#include <algorithm>
#include <cmath>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kGraphText = 12;
constexpr double kNodeRadius = 5;
constexpr double kNodeReach = 14;
/// The axis of opacity is a root, because most materials of interest have a small opacity a mm.
constexpr double kOpacityRoot = 0.5;

QColor colour_of_node(const render::TransferNode& node) {
  return QColor::fromRgbF(static_cast<float>(node.rgb.x()), static_cast<float>(node.rgb.y()),
                          static_cast<float>(node.rgb.z()));
}

}  // namespace

TransferGraph::TransferGraph(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("transfer-graph"));
  setAccessibleName(QStringLiteral("Opacity by value, over the histogram of the CT"));
  setMinimumSize(160, 110);
  setFocusPolicy(Qt::StrongFocus);
}

void TransferGraph::show_function(const render::TransferFunction& function, std::size_t component) {
  const std::size_t chosen = component < function.components().size() ? component : 0;
  const bool another = !function_ || chosen != component_;
  function_ = function;
  component_ = chosen;
  if (another) fit_axis();
  update();
}

/// The axis shows the nodes of the chosen component and some of what lies beside them.
void TransferGraph::fit_axis() {
  constexpr double kLeastMargin = 150;
  const auto& nodes = function_->components()[component_].nodes;
  const double low = nodes.front().hu;
  const double high = nodes.back().hu;
  const double margin = std::max(kLeastMargin, 0.4 * (high - low));
  low_ = low - margin;
  high_ = high + margin;
}

void TransferGraph::show_counts(std::shared_ptr<const render::ValueCounts> counts) {
  if (counts == counts_) return;
  counts_ = std::move(counts);
  update();
}

QRectF TransferGraph::plot() const { return QRectF(rect()).adjusted(30, 8, -8, -18); }

QPointF TransferGraph::point_of(double value, double opacity) const {
  const QRectF area = plot();
  const double x = area.left() + (value - low_) / (high_ - low_) * area.width();
  return {x, area.bottom() - std::pow(std::clamp(opacity, 0.0, 1.0), kOpacityRoot) * area.height()};
}

double TransferGraph::value_at(double x) const {
  const QRectF area = plot();
  return low_ + (x - area.left()) / std::max(1.0, area.width()) * (high_ - low_);
}

double TransferGraph::opacity_at(double y) const {
  const QRectF area = plot();
  const double share = std::clamp((area.bottom() - y) / std::max(1.0, area.height()), 0.0, 1.0);
  return std::pow(share, 1 / kOpacityRoot);
}

void TransferGraph::mousePressEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || !function_) return;
  const auto& nodes = function_->components()[component_].nodes;
  double nearest = kNodeReach;
  node_.reset();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const QPointF way = point_of(nodes[i].hu, nodes[i].opacity) - event->position();
    const double distance = std::hypot(way.x(), way.y());
    if (distance > nearest) continue;
    nearest = distance;
    node_ = i;
  }
  if (node_ && drag_began) drag_began();
}

void TransferGraph::mouseMoveEvent(QMouseEvent* event) {
  if (!node_ || !moved) return;
  moved(*node_, value_at(event->position().x()), opacity_at(event->position().y()));
}

void TransferGraph::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || !node_) return;
  node_.reset();
  if (drag_ended) drag_ended();
}

void TransferGraph::wheelEvent(QWheelEvent* event) {
  event->accept();
  constexpr double kNotchDegrees = 120;
  constexpr double kZoom = 1.2;
  constexpr double kNarrowest = 20;
  constexpr double kWidest = 70000;
  const double notches = std::clamp(event->angleDelta().y() / kNotchDegrees, -10.0, 10.0);
  const double middle = value_at(event->position().x());
  const double width = std::clamp((high_ - low_) / std::pow(kZoom, notches), kNarrowest, kWidest);
  const double share = (middle - low_) / (high_ - low_);
  low_ = middle - share * width;
  high_ = low_ + width;
  update();
}

/// The logarithm of the counts: bone is rare beside air.
void TransferGraph::paint_counts(QPainter& painter) const {
  if (!counts_ || counts_->bins.empty()) return;
  const double most = std::log1p(static_cast<double>(*std::ranges::max_element(counts_->bins)));
  if (!(most > 0)) return;
  const QRectF area = plot();
  const double bin = (counts_->high - counts_->low) / static_cast<double>(counts_->bins.size());
  for (std::size_t i = 0; i < counts_->bins.size(); ++i) {
    const double left = point_of(counts_->low + static_cast<double>(i) * bin, 0).x();
    const double right = point_of(counts_->low + static_cast<double>(i + 1) * bin, 0).x();
    if (right < area.left() || left > area.right()) continue;
    const double height = std::log1p(static_cast<double>(counts_->bins[i])) / most * area.height();
    painter.fillRect(QRectF(left, area.bottom() - height, std::max(1.0, right - left), height),
                     QColor(0x3a, 0x46, 0x52));
  }
}

void TransferGraph::paint_component(QPainter& painter, std::size_t component) const {
  const auto& nodes = function_->components()[component].nodes;
  const bool chosen = component == component_;
  const QColor colour = colour_of_node(render::most_opaque(function_->components()[component]));
  QPolygonF line;
  line << point_of(std::min(low_, nodes.front().hu), nodes.front().opacity);
  for (const auto& node : nodes) line << point_of(node.hu, node.opacity);
  line << point_of(std::max(high_, nodes.back().hu), nodes.back().opacity);
  painter.setPen(QPen(colour.lighter(chosen ? 130 : 100), chosen ? 3 : 1.5));
  painter.drawPolyline(line);
  if (!chosen) return;
  for (const auto& node : nodes) {
    painter.setPen(QPen(Qt::white, 1.5));
    painter.setBrush(colour_of_node(node));
    painter.drawEllipse(point_of(node.hu, node.opacity), kNodeRadius, kNodeRadius);
    painter.setBrush(Qt::NoBrush);
  }
}

void TransferGraph::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  painter.setRenderHint(QPainter::Antialiasing);
  const QRectF area = plot();
  painter.setFont(theme::font(kGraphText));
  const QFontMetricsF metrics(painter.font());
  painter.save();
  painter.setClipRect(area.adjusted(-kNodeRadius, -kNodeRadius, kNodeRadius, kNodeRadius));
  paint_counts(painter);
  if (function_) {
    for (std::size_t i = 0; i < function_->components().size(); ++i) {
      if (i != component_) paint_component(painter, i);
    }
    paint_component(painter, component_);
  }
  painter.restore();
  painter.setPen(QColor::fromRgb(theme::kWindowFaint));
  for (const double mark : {0.0, 0.1, 0.5, 1.0}) {
    const QString number = QString::number(mark, 'g', 2);
    painter.drawText(QPointF(area.left() - metrics.horizontalAdvance(number) - 5,
                             point_of(low_, mark).y() + metrics.ascent() / 2 - 1),
                     number);
  }
  constexpr int kMarks = 4;
  for (int i = 0; i <= kMarks; ++i) {
    const double value = low_ + (high_ - low_) * i / kMarks;
    const QString number = QString::number(std::lround(value));
    const double x = point_of(value, 0).x() - 0.5 * metrics.horizontalAdvance(number);
    painter.drawText(QPointF(std::clamp(x, 0.0, width() - metrics.horizontalAdvance(number)),
                             area.bottom() + metrics.ascent() + 3),
                     number);
  }
  if (!hasFocus()) return;
  painter.setPen(QPen(Qt::white, 2));
  painter.drawRect(QRectF(rect()).adjusted(1, 1, -1, -1));
}

}  // namespace nav::app
