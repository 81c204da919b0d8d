// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "nav/diagnostics.hpp"

namespace nav::fuzz {

/// Forgets every message.
class SilentDiagnostics final : public Diagnostics {
 public:
  void take(const DiagnosticEntry&) override {}
};

/// The bytes as a file with that name, in a folder in memory that belongs to this process. The file
/// of the call before is gone.
std::filesystem::path as_file(const std::uint8_t* bytes, std::size_t size, std::string_view name);

/// Checks what every message must be: one sentence in one line of at most 4 kB. Ends the process
/// otherwise.
void check_message(std::string_view message);

}  // namespace nav::fuzz
