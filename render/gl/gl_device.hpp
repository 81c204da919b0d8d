// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace nav::render {

/// True if a GL_RENDERER draws on the processor. Decides between the ways that such devices and
/// GPUs draw faster, so that a device always draws in the same way.
inline bool runs_in_software(std::string_view device) {
  for (const char* name : {"llvmpipe", "softpipe", "SwiftShader"}) {
    if (device.find(name) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace nav::render
