// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav {

/// Bytes of a large page, which starts at a multiple of them.
inline constexpr std::size_t kLargePage = std::size_t{1} << 21;

/// Asks the system to back the large pages that lie wholly in the block, mapped memory of this
/// process, with memory in one piece. A wish: the values are the same without (ADR 50).
void ask_for_large_pages(void* block, std::size_t bytes) noexcept;

}  // namespace nav
