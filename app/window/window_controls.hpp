// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/window/main_window.hpp"
#include "io/json.hpp"

namespace nav::app {

/// The named controls of a window, as reports list them: name, kind, accessible name, key, size,
/// whether its text is cut, and the contrast of its text.
io::Json controls_of(const MainWindow& window);

/// The page with the table between the lines "<!-- controls -->" and "<!-- end -->" made anew, one
/// row for each control. kMalformedData: a line is missing.
Result<std::string> with_controls(const std::string& page, const io::Json& controls);

/// Makes every text of buttons, check boxes and labels 40 % longer, as another language may be: for
/// tests of the layout. Texts that the window sets later have their own length.
void lengthen_texts(QWidget& window);

/// Ratio of the contrast of two colours, 1 to 21 (WCAG 2.1, relative luminance of sRGB).
double contrast_of(QRgb a, QRgb b);

}  // namespace nav::app
