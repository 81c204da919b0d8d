// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/session_page.hpp"

#include <QHBoxLayout>
#include <QPainter>
#include <QVBoxLayout>

#include "app/window/flow_layout.hpp"
#include "app/window/theme.hpp"

namespace nav::app {

SessionPage::SessionPage(QWidget* parent)
    : QWidget(parent),
      path_(
          small_field(QStringLiteral("session-path"), QStringLiteral("File of the session"), this)),
      save_(small_button(QStringLiteral("session-save"), QStringLiteral("Save"),
                         QStringLiteral("Save the session as this file"), this)),
      replace_(small_button(QStringLiteral("session-replace"), QStringLiteral("Replace the file"),
                            QStringLiteral("Replace the file that is there"), this)),
      keep_(small_button(QStringLiteral("session-keep"), QStringLiteral("Keep it"),
                         QStringLiteral("Keep the file that is there"), this)),
      words_(small_label({}, this)) {
  setObjectName(QStringLiteral("session-page"));
  setAccessibleName(QStringLiteral("Session"));
  words_->setObjectName(QStringLiteral("session-words"));
  words_->setAccessibleName(QStringLiteral("About the file of the session"));
  path_->setPlaceholderText(QStringLiteral("procedure.toml"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(4);
  column->addWidget(small_label(QStringLiteral("Session file (save: Ctrl+S)"), this));
  auto* row = new FlowLayout(4);
  row->addWidget(path_);
  row->addWidget(save_);
  column->addLayout(row);
  column->addWidget(words_);
  auto* answers = new FlowLayout(4);
  answers->addWidget(replace_);
  answers->addWidget(keep_);
  column->addLayout(answers);
  column->addStretch(1);
  QObject::connect(save_, &QPushButton::clicked, this, [this] {
    if (save) save();
  });
  QObject::connect(path_, &QLineEdit::returnPressed, this, [this] {
    if (save) save();
  });
  QObject::connect(replace_, &QPushButton::clicked, this, [this] {
    if (replace) replace();
  });
  QObject::connect(keep_, &QPushButton::clicked, this,
                   [this] { say(QStringLiteral("Not saved: give another name."), false); });
  say({}, false);
}

void SessionPage::say(const QString& words, bool asks) {
  words_->setText(words);
  replace_->setVisible(asks);
  keep_->setVisible(asks);
}

RecoveryBar::RecoveryBar(QWidget* parent) : QWidget(parent), words_(small_label({}, this)) {
  setObjectName(QStringLiteral("recovery"));
  setAccessibleName(QStringLiteral("Unsaved changes of another window"));
  words_->setObjectName(QStringLiteral("recovery-words"));
  words_->setAccessibleName(QStringLiteral("Changes that another window left"));
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(10, 6, 10, 6);
  row->addWidget(words_, 1);
  auto* yes = small_button(QStringLiteral("recovery-restore"), QStringLiteral("Restore"),
                           QStringLiteral("Open the changes here"), this);
  auto* no = small_button(QStringLiteral("recovery-discard"), QStringLiteral("Discard"),
                          QStringLiteral("Move the changes away"), this);
  row->addWidget(yes);
  row->addWidget(no);
  QObject::connect(yes, &QPushButton::clicked, this, [this] {
    if (restore) restore();
  });
  QObject::connect(no, &QPushButton::clicked, this, [this] {
    if (discard) discard();
  });
  hide();
}

void RecoveryBar::say(const QString& words) {
  words_->setText(words);
  setVisible(!words.isEmpty());
}

void RecoveryBar::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
  painter.setPen(QPen(QColor::fromRgb(theme::kWindowAccent), 2));
  painter.drawRect(rect().adjusted(1, 1, -1, -1));
}

}  // namespace nav::app
