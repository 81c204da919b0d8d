// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <memory>
#include <optional>

#include "render/transfer/transfer_editor.hpp"

namespace nav::app {

/// Components of a transfer function over the histogram of the CT: the opacity of 1 mm by the
/// value. Nodes of the chosen component are dragged; the wheel zooms the axis of the values.
class TransferGraph final : public QWidget {
 public:
  explicit TransferGraph(QWidget* parent);

  void show_function(const render::TransferFunction& function, std::size_t component);
  /// Null: none.
  void show_counts(std::shared_ptr<const render::ValueCounts> counts);
  /// Point of a node, pixels of the widget.
  [[nodiscard]] QPointF point_of(double value, double opacity) const;

  std::function<void()> drag_began, drag_ended;
  std::function<void(std::size_t node, double value, double opacity)> moved;

 private:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  [[nodiscard]] QRectF plot() const;
  [[nodiscard]] double value_at(double x) const;
  [[nodiscard]] double opacity_at(double y) const;
  void fit_axis();
  void paint_counts(QPainter& painter) const;
  void paint_component(QPainter& painter, std::size_t component) const;

  std::optional<render::TransferFunction> function_;
  std::size_t component_ = 0;
  std::shared_ptr<const render::ValueCounts> counts_;
  double low_ = 0, high_ = 1;        ///< Values at the ends of the axis.
  std::optional<std::size_t> node_;  ///< Node that is dragged.
};

}  // namespace nav::app
