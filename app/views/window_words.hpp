// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/views/panels.hpp"
#include "render/window/window.hpp"

namespace nav::app {

/// Overlay text of the 3D view in a window, which has no panels: states and causes, numbers while
/// they are valid, note, warning, banner, and the letters of the patient's directions for the
/// context's camera. ended: no new data will come; a line says that the view is not live.
std::vector<render::WindowWords> window_words(const PanelContext& context, bool ended);

}  // namespace nav::app
