// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::render {

/// Whether the compute shaders of the device calculate faster than its fragment shaders by enough
/// to be worth it: measured once for every device in a process, some 50 ms. Never on software
/// rasterisers, where both are the same processor, nor where the measurement's programs do not
/// link. Needs the context current; leaves another framebuffer, program and vertex array bound.
/// Internal to render/.
bool compute_is_faster();

}  // namespace nav::render
