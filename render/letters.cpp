// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/letters.hpp"

#include <cstddef>

#include "nav/check.hpp"

namespace nav::render {
namespace {

/// The first letter of a text (RFC 3629). Overlong forms and surrogates are not letters.
Letter first_letter(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  const Letter none{std::string(1, text[0]), {}};
  if (lead < 0x80) return {none.bytes, char32_t{lead}};
  if (lead < 0xc2 || lead > 0xf4) return none;
  const std::size_t count = lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  if (text.size() < count) return none;
  char32_t code = lead & (0xffU >> (count + 1));
  for (std::size_t i = 1; i < count; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return none;
    code = code << 6 | (byte(i) & 0x3fU);
  }
  const bool overlong = (count == 3 && code < 0x800) || (count == 4 && code < 0x10000);
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  if (overlong || surrogate || code > 0x10ffff) return none;
  return {std::string(text.substr(0, count)), code};
}

}  // namespace

std::vector<Letter> letters_of(std::string_view text) {
  std::vector<Letter> letters;
  while (!text.empty()) {
    letters.push_back(first_letter(text));
    text.remove_prefix(letters.back().bytes.size());
  }
  return letters;
}

void drop_last_letter(std::string& text) {
  NAV_CHECK(!text.empty());
  text.resize(text.size() - letters_of(text).back().bytes.size());
}

}  // namespace nav::render
