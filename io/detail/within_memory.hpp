// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <new>
#include <sstream>

#include "nav/result.hpp"

namespace nav::io::detail {

/// Runs \p read, which returns a Result. A lack of memory becomes kUnavailable, with the file and
/// what it needs: \p bytes.
template <class Read>
auto within_memory(const std::filesystem::path& path, double bytes, const Read& read)
    -> decltype(read()) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    constexpr double kGiga = 1e9;
    std::ostringstream text;
    text.precision(2);
    text << path.string() << ": out of memory while it was read; it needs "
         << (bytes < kGiga ? bytes / 1e6 : bytes / kGiga) << (bytes < kGiga ? " MB" : " GB");
    return Error{ErrorCode::kUnavailable, text.str()};
  }
}

}  // namespace nav::io::detail
