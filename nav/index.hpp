// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav {

/// Converts a signed count or index, >= 0, to the index type of the standard containers.
constexpr std::size_t as_size(int n) { return static_cast<std::size_t>(n); }

}  // namespace nav
