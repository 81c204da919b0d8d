// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_text.hpp"

namespace nav::devices {

std::string igtl_escaped(std::string_view text, std::size_t longest) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (const char c : text.substr(0, longest)) {
    if (c >= ' ' && c <= '~' && c != '\\') {
      out += c;
      continue;
    }
    const auto value = static_cast<unsigned char>(c);
    out += "\\x";
    out += kDigits[value >> 4];
    out += kDigits[value & 15];
  }
  if (text.size() > longest) out += "...";
  return out;
}

std::string_view igtl_until_nul(std::string_view field) {
  return field.substr(0, field.find('\0'));
}

}  // namespace nav::devices
