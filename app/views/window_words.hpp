// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/views/panels.hpp"
#include "render/window/window.hpp"

namespace nav::app {

/// What stands over the 3D view in a window, where there are no panels: states and causes, numbers
/// while they hold, note, warning, banner, and which way the patient lies as seen by the context's
/// camera. ended: nothing more will come, so that what is seen is not live.
std::vector<render::WindowWords> window_words(const PanelContext& context, bool ended);

}  // namespace nav::app
