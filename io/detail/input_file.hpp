// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "nav/result.hpp"

namespace nav::io::detail {

/// Regular file open for reading at any 64-bit offset. Reading is thread-safe.
class InputFile {
 public:
  /// Opens a file. Rejects paths that are missing, unreadable, or not regular files.
  static Result<InputFile> open(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Length of the file when it was opened, bytes.
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// Fills \p out from \p offset. Returns the number of bytes read (fewer only at the end).
  [[nodiscard]] Result<std::size_t> read_at(std::int64_t offset, std::span<std::byte> out) const;

 private:
  InputFile() = default;
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace nav::io::detail
