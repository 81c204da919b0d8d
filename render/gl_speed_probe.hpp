// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"

namespace nav::render {

/// Whether the compute shaders of the device calculate faster than its fragment shaders by enough
/// to be worth it: measured once for every device in a process, some 50 ms. Never on software
/// rasterisers, where both are the same processor. Needs the context current; leaves another
/// framebuffer, program and vertex array bound. Internal to render/.
Result<bool> compute_is_faster();

}  // namespace nav::render
