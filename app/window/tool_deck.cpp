// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/tool_deck.hpp"

#include <QPainter>
#include <QScrollBar>
#include <QVBoxLayout>
#include <algorithm>

#include "app/window/flow_layout.hpp"
#include "app/window/small_controls.hpp"
#include "app/window/theme.hpp"

namespace nav::app {

ToolDeck::ToolDeck(QWidget* parent) : QWidget(parent), tabs_(new QWidget(this)) {
  setObjectName(QStringLiteral("tools"));
  setAccessibleName(QStringLiteral("Panels"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 4, 4, 4);
  column->setSpacing(2);
  constexpr int kTabGap = 4;
  tabs_->setLayout(new FlowLayout(kTabGap));
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
  button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  // A panel that is too low for its controls scrolls them.
  auto* scroll = new QScrollArea(this);
  scroll->setObjectName(page->objectName() + QStringLiteral("-scroll"));
  scroll->setAccessibleName(page->accessibleName());
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setWidget(page);
  const int index = pages_->addWidget(scroll);
  scrolls_.push_back(scroll);
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

int ToolDeck::wanted_width() const {
  const QScrollArea& scroll = *scrolls_.at(static_cast<std::size_t>(chosen()));
  const QMargins margins = layout()->contentsMargins();
  const int page =
      scroll.widget()->minimumSizeHint().width() + scroll.verticalScrollBar()->sizeHint().width();
  return std::max(page, tabs_->layout()->minimumSize().width()) + margins.left() + margins.right();
}

void ToolDeck::show_control(QWidget* control) {
  for (QScrollArea* scroll : scrolls_) {
    if (scroll->isAncestorOf(control)) scroll->ensureWidgetVisible(control, 0, 4);
  }
}

void ToolDeck::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
}

}  // namespace nav::app
