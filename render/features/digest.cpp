// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/digest.hpp"

#include <array>
#include <cmath>
#include <openssl/evp.h>

#include "nav/check.hpp"

namespace nav::render::features {

struct Digest::Context {
  EVP_MD_CTX* evp = EVP_MD_CTX_new();
  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() { EVP_MD_CTX_free(evp); }
};

Digest::Digest() : context_(std::make_unique<Context>()) {
  NAV_CHECK(EVP_DigestInit_ex(context_->evp, EVP_sha256(), nullptr) == 1);
}
Digest::~Digest() = default;

void Digest::add(std::span<const std::byte> bytes) {
  NAV_CHECK(EVP_DigestUpdate(context_->evp, bytes.data(), bytes.size()) == 1);
}

void Digest::add(std::string_view text) {
  add(static_cast<double>(text.size()));
  add(std::as_bytes(std::span(text.data(), text.size())));
}

void Digest::add(double number) {
  // All NaN values share one bit pattern, and so do both zeros.
  const double plain = std::isnan(number) ? std::nan("") : number + 0.0;
  add(std::as_bytes(std::span(&plain, 1)));
}

void Digest::add(const VoxelGrid& grid) {
  for (const int n : grid.size) add(static_cast<double>(n));
  for (int a = 0; a < 3; ++a) add(grid.spacing_mm[a]);
  for (int a = 0; a < 3; ++a) add(grid.origin_mm[a]);
  for (int a = 0; a < 9; ++a) add(grid.directions(a / 3, a % 3));
}

std::string Digest::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> raw{};
  unsigned length = 0;
  NAV_CHECK(EVP_DigestFinal_ex(context_->evp, raw.data(), &length) == 1);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < length; ++i) {
    text += kDigits[raw[i] >> 4];
    text += kDigits[raw[i] & 15];
  }
  return text;
}

}  // namespace nav::render::features
