// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nav::render {

/// A letter of a text in UTF-8.
struct Letter {
  std::string bytes;
  std::optional<char32_t> code;  ///< Unicode code point; absent: one byte that belongs to no
                                 ///< letter.
};

/// The letters of a text, in order. Together their bytes are the text.
std::vector<Letter> letters_of(std::string_view text);

/// Removes the last letter. Precondition: the text is not empty.
void drop_last_letter(std::string& text);

}  // namespace nav::render
