// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"

namespace nav::render {

/// Measures whether the current device interpolates 16-bit voxels more coarsely than 1e-4 of the
/// step between two of them; many graphics cards use 8-bit fractions. Changes framebuffer, viewport
/// and program: call it under a GlStateGuard.
Result<bool> filter_is_coarse();

}  // namespace nav::render
