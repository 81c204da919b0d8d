// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/digest.hpp"

#include <array>
#include <openssl/evp.h>
#include <string_view>

#include "nav/check.hpp"

namespace nav::io {

std::string sha256_hex(std::span<const std::byte> bytes) {
  constexpr std::size_t kDigestBytes = 32;
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  const int ok =
      EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  NAV_CHECK(ok == 1 && size == kDigestBytes, ok, size);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < kDigestBytes; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

std::string sha256_hex(std::string_view text) {
  return sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace nav::io
