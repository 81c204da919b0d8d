// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/tool_deck.hpp"

#include <QHBoxLayout>
#include <QPainter>
#include <QVBoxLayout>

#include "app/window/small_controls.hpp"
#include "app/window/theme.hpp"

namespace nav::app {

ToolDeck::ToolDeck(QWidget* parent) : QWidget(parent), tabs_(new QWidget(this)) {
  setObjectName(QStringLiteral("tools"));
  setAccessibleName(QStringLiteral("Panels"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 4, 4, 4);
  column->setSpacing(2);
  auto* row = new QHBoxLayout(tabs_);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  column->addWidget(tabs_);
  auto* page = new QWidget(this);
  pages_ = new QStackedLayout(page);
  column->addWidget(page, 1);
}

void ToolDeck::add(const QString& name, const QString& title, const QString& accessible,
                   QWidget* page) {
  auto* button = small_button(name, title, accessible, tabs_);
  button->setCheckable(true);
  button->setAutoExclusive(true);
  const int index = pages_->addWidget(page);
  QObject::connect(button, &QPushButton::clicked, this, [this, index] {
    if (pressed) pressed(index);
  });
  tabs_->layout()->addWidget(button);
  buttons_.push_back(button);
  choose(0);
}

void ToolDeck::choose(int page) {
  pages_->setCurrentIndex(page);
  buttons_.at(static_cast<std::size_t>(page))->setChecked(true);
}

void ToolDeck::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
}

}  // namespace nav::app
