// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSlider>

namespace nav::app {

/// Controls of the panels: at least kSmallControl pixels high, with a stable name and an accessible
/// one.
inline constexpr int kSmallControl = 28;

QPushButton* small_button(const QString& name, const QString& text, const QString& accessible,
                          QWidget* parent);
/// Steps of small_slider(), from its low to its high end.
inline constexpr int kSliderSteps = 1000;
QSlider* small_slider(Qt::Orientation orientation, const QString& name, const QString& accessible,
                      QWidget* parent);
/// A number field that takes its value when the user has finished it, with a point in every locale.
QDoubleSpinBox* small_number(const QString& name, const QString& accessible, double low,
                             double high, int decimals, QWidget* parent);
QComboBox* small_choice(const QString& name, const QString& accessible, QWidget* parent);
/// A field of one line of text.
QLineEdit* small_field(const QString& name, const QString& accessible, QWidget* parent);
/// Words that wrap.
QLabel* small_label(const QString& text, QWidget* parent);

/// Sets a value without telling those who listen.
void set_quietly(QSlider& slider, double share);
void set_quietly(QDoubleSpinBox& number, double value);
double share_of(const QSlider& slider);

}  // namespace nav::app
