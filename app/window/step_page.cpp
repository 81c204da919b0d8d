// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/step_page.hpp"

#include <QVBoxLayout>

namespace nav::app {

StepPage::StepPage(QLabel* words, QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("step-page"));
  setAccessibleName(QStringLiteral("Step"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(4);
  words->setParent(this);
  column->addWidget(words);
  column->addStretch(1);
}

void StepPage::add(int step, QWidget* controls) {
  auto* column = static_cast<QVBoxLayout*>(layout());
  column->insertWidget(column->count() - 1, controls);
  controls->hide();
  controls_[step] = controls;
}

void StepPage::choose(int step) {
  for (const auto& [number, controls] : controls_) controls->setVisible(number == step);
}

}  // namespace nav::app
