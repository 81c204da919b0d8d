// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/large_pages.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>

namespace nav {

void ask_for_large_pages([[maybe_unused]] void* block,
                         [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  const auto past = reinterpret_cast<std::uintptr_t>(block) % kLargePage;
  const std::size_t skipped = past == 0 ? 0 : kLargePage - past;
  if (bytes < skipped + kLargePage) return;
  madvise(static_cast<char*>(block) + skipped, (bytes - skipped) / kLargePage * kLargePage,
          MADV_HUGEPAGE);
#endif
}

}  // namespace nav
