// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/flow_layout.hpp"

#include <QHBoxLayout>
#include <QLabel>
#include <algorithm>

namespace nav::app {

FlowLayout::~FlowLayout() {
  for (QLayoutItem* item : items_) delete item;
}

QLayoutItem* FlowLayout::itemAt(int index) const {
  return index >= 0 && index < count() ? items_[static_cast<std::size_t>(index)] : nullptr;
}

QLayoutItem* FlowLayout::takeAt(int index) {
  QLayoutItem* item = itemAt(index);
  if (item != nullptr) items_.erase(items_.begin() + index);
  return item;
}

int FlowLayout::heightForWidth(int width) const { return place(QRect(0, 0, width, 0), false); }

QSize FlowLayout::minimumSize() const {
  QSize size(0, 0);
  for (const QLayoutItem* item : items_) {
    if (!item->isEmpty()) size = size.expandedTo(item->minimumSize());
  }
  return size;
}

QSize FlowLayout::sizeHint() const {
  QSize size(0, 0);
  for (const QLayoutItem* item : items_) {
    if (item->isEmpty()) continue;
    const QSize one = item->sizeHint().expandedTo(item->minimumSize());
    size = {size.width() + (size.width() > 0 ? gap_ : 0) + one.width(),
            std::max(size.height(), one.height())};
  }
  return size;
}

void FlowLayout::setGeometry(const QRect& rect) {
  QLayout::setGeometry(rect);
  place(rect, true);
}

/// Fills row after row. Returns the height of all of them.
int FlowLayout::place(const QRect& rect, bool apply) const {
  int y = rect.y();
  std::size_t first = 0;
  const auto shown = [&](std::size_t i) { return !items_[i]->isEmpty(); };
  const auto width_of = [&](std::size_t i) {
    return std::max(items_[i]->sizeHint().width(), items_[i]->minimumSize().width());
  };
  while (first < items_.size()) {
    int used = 0;
    int expanding = 0;
    int height = 0;
    std::size_t last = first;
    for (; last < items_.size(); ++last) {
      if (!shown(last)) continue;
      const int wanted = used + (used > 0 ? gap_ : 0) + width_of(last);
      if (used > 0 && wanted > rect.width()) break;
      used = wanted;
      height = std::max(height, items_[last]->sizeHint().height());
      if (items_[last]->expandingDirections().testFlag(Qt::Horizontal)) ++expanding;
    }
    if (height == 0) break;
    const int left = std::max(0, rect.width() - used);
    int x = rect.x();
    for (std::size_t i = first; apply && i < last; ++i) {
      if (!shown(i)) continue;
      const bool expands = items_[i]->expandingDirections().testFlag(Qt::Horizontal);
      const int width = std::min(rect.width(), width_of(i) + (expands ? left / expanding : 0));
      items_[i]->setGeometry(QRect(x, y, width, height));
      x += width + gap_;
    }
    y += height + gap_;
    first = last;
  }
  return std::max(0, y - gap_ - rect.y());
}

QWidget* labelled(const QString& label, QWidget* control, QWidget* parent) {
  constexpr int kLabelGap = 4;
  auto* both = new QWidget(parent);
  auto* row = new QHBoxLayout(both);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(kLabelGap);
  auto* words = new QLabel(label, both);
  words->setObjectName(control->objectName() + QStringLiteral("-label"));
  row->addWidget(words);
  row->addWidget(control, 1);
  return both;
}

}  // namespace nav::app
