// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav {

/// Size of a large page, bytes. A large page starts at a multiple of its size.
inline constexpr std::size_t kLargePage = std::size_t{1} << 21;

/// Asks the system to back the large pages that lie wholly in \p block, mapped memory of this
/// process, with contiguous memory. The system may ignore it; the values do not depend on it (ADR
/// 50).
void ask_for_large_pages(void* block, std::size_t bytes) noexcept;

}  // namespace nav
