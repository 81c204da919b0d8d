// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::render {

/// True if the compute shaders of the device calculate faster than its fragment shaders by a
/// worthwhile factor. Measured once per device and process, about 50 ms. Always false on software
/// rasterisers, where both run on the same processor, and if the programs of the measurement do not
/// link. Needs the context current; leaves another framebuffer, program and vertex array bound.
/// Internal to render/.
bool compute_is_faster();

}  // namespace nav::render
