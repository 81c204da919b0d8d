// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nav::io::detail {

/// Removes blanks, tabs and carriage returns from both ends.
std::string_view trim(std::string_view text);
/// Splits a text at blanks, tabs and line ends.
std::vector<std::string_view> split_words(std::string_view text);
/// Parses the whole text as one decimal number, independent of the locale; nan and inf are
/// accepted.
std::optional<double> parse_double(std::string_view text);
/// Parses the whole text as one decimal integer.
std::optional<std::int64_t> parse_int(std::string_view text);
/// Parses blank-separated numbers; nothing when a piece is not a number.
std::optional<std::vector<double>> parse_doubles(std::string_view text);
/// Shortest text that reads back as the same number.
std::string to_text(double value);
/// At most 60 characters of a text on one line, for messages.
std::string excerpt(std::string_view text);
/// True for texts that are equal apart from the case of ASCII letters.
bool equals_ignoring_case(std::string_view a, std::string_view b);

}  // namespace nav::io::detail
