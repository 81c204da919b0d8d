// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/small_controls.hpp"

#include <QLocale>
#include <QSignalBlocker>
#include <algorithm>
#include <cmath>

namespace nav::app {

QPushButton* small_button(const QString& name, const QString& text, const QString& accessible,
                          QWidget* parent) {
  auto* made = new QPushButton(text, parent);
  made->setObjectName(name);
  made->setAccessibleName(accessible);
  made->setToolTip(accessible);
  made->setProperty("small", true);
  made->setMinimumHeight(kSmallControl);
  return made;
}

QSlider* small_slider(Qt::Orientation orientation, const QString& name, const QString& accessible,
                      QWidget* parent) {
  auto* made = new QSlider(orientation, parent);
  made->setObjectName(name);
  made->setAccessibleName(accessible);
  made->setToolTip(accessible);
  made->setRange(0, kSliderSteps);
  made->setPageStep(kSliderSteps / 20);
  made->setSingleStep(kSliderSteps / 100);
  if (orientation == Qt::Horizontal) {
    made->setMinimumHeight(kSmallControl);
  } else {
    made->setMinimumWidth(kSmallControl);
  }
  return made;
}

QDoubleSpinBox* small_number(const QString& name, const QString& accessible, double low,
                             double high, int decimals, QWidget* parent) {
  auto* made = new QDoubleSpinBox(parent);
  made->setObjectName(name);
  made->setAccessibleName(accessible);
  made->setToolTip(accessible);
  made->setLocale(QLocale::c());
  made->setDecimals(decimals);
  made->setRange(low, high);
  made->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  made->setKeyboardTracking(false);
  made->setButtonSymbols(QAbstractSpinBox::NoButtons);  // Wheel and arrow keys step.
  made->setMinimumHeight(kSmallControl);
  return made;
}

QComboBox* small_choice(const QString& name, const QString& accessible, QWidget* parent) {
  auto* made = new QComboBox(parent);
  made->setObjectName(name);
  made->setAccessibleName(accessible);
  made->setToolTip(accessible);
  made->setMinimumHeight(kSmallControl);
  made->setSizeAdjustPolicy(QComboBox::AdjustToContents);
  made->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  return made;
}

QLineEdit* small_field(const QString& name, const QString& accessible, QWidget* parent) {
  auto* made = new QLineEdit(parent);
  made->setObjectName(name);
  made->setAccessibleName(accessible);
  made->setToolTip(accessible);
  made->setMinimumHeight(kSmallControl);
  return made;
}

QLabel* small_label(const QString& text, QWidget* parent) {
  auto* made = new QLabel(text, parent);
  made->setTextFormat(Qt::PlainText);
  made->setWordWrap(true);
  return made;
}

void set_quietly(QSlider& slider, double share) {
  const QSignalBlocker quiet(slider);
  slider.setValue(static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kSliderSteps)));
}

void set_quietly(QDoubleSpinBox& number, double value) {
  const QSignalBlocker quiet(number);
  number.setValue(value);
}

double share_of(const QSlider& slider) {
  return static_cast<double>(slider.value()) / kSliderSteps;
}

}  // namespace nav::app
