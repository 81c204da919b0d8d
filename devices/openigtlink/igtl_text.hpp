// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nav::devices {

/// A text from the wire as it may stand in a message: at most \p longest bytes of it, other
/// characters than printable ASCII as \xNN, and "..." where it was cut.
std::string igtl_escaped(std::string_view text, std::size_t longest = 64);

/// The part of a field of fixed width before its first NUL; the whole field if it has none.
std::string_view igtl_until_nul(std::string_view field);

}  // namespace nav::devices
