// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <optional>

#include "render/predicates/model.hpp"

namespace nav::app {

/// The bars of a predicate histogram (Schulte zu Berge et al. 2014, Fig. 4): the height is the
/// importance, the fill the colour. A bar is chosen by a click and dragged to another height; the
/// arrow keys do the same.
class HistogramBars final : public QWidget {
 public:
  explicit HistogramBars(QWidget* parent);

  void show_model(const render::PredicateModel& model, std::optional<std::size_t> selected);
  [[nodiscard]] std::size_t size() const { return model_.entries.size(); }
  /// The bar with a name; spaces of names may be written as '-'. Absent: there is none.
  [[nodiscard]] std::optional<std::size_t> find(const QString& name) const;
  /// Point of a bar at an importance, pixels of the widget.
  [[nodiscard]] QPointF point_of(std::size_t bar, double importance) const;
  [[nodiscard]] double importance_of(std::size_t bar) const;

  std::function<void(std::size_t bar)> picked;
  std::function<void()> drag_began, drag_ended;
  std::function<void(std::size_t bar, double importance)> dragged;

 private:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  bool event(QEvent* event) override;  // Tool tips.
  [[nodiscard]] QRectF plot() const;
  [[nodiscard]] QRectF slot_of(std::size_t bar) const;
  [[nodiscard]] std::optional<std::size_t> bar_at(const QPointF& at) const;

  render::PredicateModel model_;
  std::optional<std::size_t> selected_;
  struct Drag {
    std::size_t bar;
    double from_y;
    double importance;
    bool moved = false;
  };
  std::optional<Drag> drag_;
};

}  // namespace nav::app
