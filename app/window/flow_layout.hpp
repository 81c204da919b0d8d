// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QLayout>
#include <vector>

namespace nav::app {

/// A row of controls that continues in further rows where the width is too small, so that no
/// control is cut. Controls whose horizontal size policy expands share what is left of their row.
class FlowLayout final : public QLayout {
 public:
  explicit FlowLayout(int gap) : gap_(gap) { setContentsMargins(0, 0, 0, 0); }
  ~FlowLayout() override;

  void addItem(QLayoutItem* item) override { items_.push_back(item); }
  [[nodiscard]] int count() const override { return static_cast<int>(items_.size()); }
  [[nodiscard]] QLayoutItem* itemAt(int index) const override;
  QLayoutItem* takeAt(int index) override;
  [[nodiscard]] Qt::Orientations expandingDirections() const override { return {}; }
  [[nodiscard]] bool hasHeightForWidth() const override { return true; }
  [[nodiscard]] int heightForWidth(int width) const override;
  /// The widest control, and one row.
  [[nodiscard]] QSize minimumSize() const override;
  /// All controls in one row.
  [[nodiscard]] QSize sizeHint() const override;
  void setGeometry(const QRect& rect) override;

 private:
  int place(const QRect& rect, bool apply) const;

  int gap_;
  std::vector<QLayoutItem*> items_;  ///< Owned.
};

/// A control with its label before it, which stay together in a row.
QWidget* labelled(const QString& label, QWidget* control, QWidget* parent);

}  // namespace nav::app
