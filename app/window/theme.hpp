// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QColor>
#include <QFont>
#include <QPainter>
#include <QString>
#include <string>

#include "nav/safety.hpp"

namespace nav::app::theme {

inline constexpr QRgb kWindowBackground = 0xff101418;
inline constexpr QRgb kWindowPanel = 0xff1b2229;
inline constexpr QRgb kWindowEdge = 0xff36424d;
inline constexpr QRgb kWindowText = 0xffe6ebf0;
inline constexpr QRgb kWindowFaint = 0xffa7b2bc;
inline constexpr QRgb kWindowAccent = 0xff8fd3ff;  ///< Needle, marked side, focus, chosen step.

inline constexpr QRgb kWindowStructure = 0xffbf73ff;  ///< Critical structures.

/// Colour of a state: green, amber, grey. Lost has the grey of stale, and another shape and word.
QColor colour_of_state(SafetyState state);

/// Draws the shape of a state into a square: valid a disc, degraded a triangle, stale a bar, lost a
/// cross.
void draw_state_shape(QPainter& painter, const QRectF& square, SafetyState state);

/// Factor of all texts: the application's font against kTextPixels. 1 unless set_text_scale() or
/// the program sets that font in pixels.
inline constexpr int kTextPixels = 14;
double text_scale();
/// Sets it, 1 to 2; widgets take it over with the next style_sheet().
void set_text_scale(double scale);
/// A length that grows with the texts, pixels.
int scaled(int pixels);

/// Font of the window, pixels of height at the text scale 1.
QFont font(int pixels, bool bold = false);
/// The font, smaller where a line would be wider than a width, but not below 9 pixels. fits, if not
/// null: becomes false if even that is too wide.
QFont fitting_font(const QString& line, int pixels, double width, bool bold = false,
                   bool* fits = nullptr);

/// Draws one line of text on a dark ground, so that it can be read over any image. Returns where it
/// ends. (x, y) is the upper left corner.
double draw_tag(QPainter& painter, double x, double y, const QString& text, const QFont& font,
                const QColor& colour);

/// Text without control characters: names come from files.
QString plain(const std::string& text);

/// Style sheet of buttons and labels.
QString style_sheet();

}  // namespace nav::app::theme
