// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPushButton>
#include <QScrollArea>
#include <QStackedLayout>
#include <QWidget>
#include <functional>
#include <vector>

namespace nav::app {

/// Panels of which one is shown, with a button for each.
class ToolDeck final : public QWidget {
 public:
  explicit ToolDeck(QWidget* parent);

  /// Adds a panel. name: of its button.
  void add(const QString& name, const QString& title, const QString& accessible, QWidget* page);
  void choose(int page);
  [[nodiscard]] int chosen() const { return pages_->currentIndex(); }
  /// Width that the chosen panel needs, so that nothing in it is cut.
  [[nodiscard]] int wanted_width() const;
  /// Scrolls its panel until a control can be seen.
  void show_control(QWidget* control);
  /// Called when the user presses a button.
  std::function<void(int page)> pressed;

 private:
  void paintEvent(QPaintEvent* event) override;

  QWidget* tabs_;
  QStackedLayout* pages_;
  std::vector<QPushButton*> buttons_;
  std::vector<QScrollArea*> scrolls_;
};

}  // namespace nav::app
