// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::io::mcap {

/// Bytes that can be read at any 64-bit offset: a file, or memory. Reading is thread-safe.
class Input {
 public:
  virtual ~Input() = default;
  /// Name for messages.
  [[nodiscard]] virtual const std::string& name() const = 0;
  /// Length when it was opened, bytes.
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills \p out from \p offset; returns the number of bytes read, fewer only at the end.
  [[nodiscard]] virtual Result<std::size_t> read_at(std::uint64_t offset,
                                                    std::span<std::byte> out) const = 0;
};

/// Opens a regular file. Errors: kNotFound, kIo.
Result<std::shared_ptr<const Input>> open_input(const std::filesystem::path& path);
/// Reads from memory, which must outlive it.
std::shared_ptr<const Input> memory_input(std::string name, std::span<const std::byte> bytes);

/// A moving view of an input, so that many small reads cost few system calls. Not thread-safe.
class Window {
 public:
  /// Largest view, bytes.
  static constexpr std::size_t kBytes = std::size_t{64} << 10;
  /// \p input must outlive it.
  explicit Window(const Input& input) : input_(&input) {}
  /// The bytes from \p offset on: \p count (at most kBytes), or fewer at the end. They lie in the
  /// window until the next call.
  Result<std::span<const std::byte>> peek(std::uint64_t offset, std::size_t count);
  /// All bytes of the window from \p offset on, at least \p count unless the end is near.
  Result<std::span<const std::byte>> peek_some(std::uint64_t offset, std::size_t count);

 private:
  const Input* input_;
  std::vector<std::byte> bytes_;
  std::uint64_t start_ = 0;
  std::size_t filled_ = 0;
};

}  // namespace nav::io::mcap
