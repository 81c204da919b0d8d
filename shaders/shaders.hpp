// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace nav::shaders {

/// Text of a file of this folder, embedded at build time. \p name: for example "include/ct.glsl".
/// Empty if there is no such file.
std::string_view source(std::string_view name);

}  // namespace nav::shaders
