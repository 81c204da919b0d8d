// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav {

/// A count or an index of the standard containers from one that arithmetic was done with; >= 0.
constexpr std::size_t as_size(int n) { return static_cast<std::size_t>(n); }

}  // namespace nav
