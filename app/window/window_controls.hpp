// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/window/main_window.hpp"
#include "io/json.hpp"

namespace nav::app {

/// The named controls of a window, as reports list them: name, kind, accessible name, key, size,
/// whether its text is cut, and the contrast of its text.
io::Json controls_of(const MainWindow& window);

/// Ratio of the contrast of two colours, 1 to 21 (WCAG 2.1, relative luminance of sRGB).
double contrast_of(QRgb a, QRgb b);

}  // namespace nav::app
