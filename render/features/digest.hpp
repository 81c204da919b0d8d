// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "nav/volume.hpp"

namespace nav::render::features {

/// SHA-256 (FIPS 180-4) of all added data, in order. Numbers are added by their bits.
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  void add(std::span<const std::byte> bytes);
  void add(std::string_view text);
  void add(double number);
  void add(const VoxelGrid& grid);
  /// Returns 64 lower-case hexadecimal digits and ends the digest.
  [[nodiscard]] std::string hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace nav::render::features
