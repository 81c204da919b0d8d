// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"

namespace nav::io {

/// A file that appears under its name only when complete: bytes go to a temporary name in the same
/// folder; commit() syncs and renames. Destroyed without commit, nothing is left. Writing to
/// something that exists and is not a regular file (/dev/full, a pipe) goes straight to it. Of a
/// link the file that it names is replaced; the link stays. Not thread-safe.
class AtomicFile {
 public:
  static Result<AtomicFile> create(const std::filesystem::path& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Appends. Errors: kIo, naming the file and the system's reason (disk full, …).
  Result<void> write(std::span<const std::byte> bytes);
  Result<void> write(std::string_view text);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Syncs and renames; the file is closed whatever happens.
  Result<void> commit();

 private:
  AtomicFile() = default;
  void abandon() noexcept;
  std::filesystem::path path_;
  std::filesystem::path temporary_;  ///< Empty when writing straight.
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Whole content at once, through an AtomicFile.
Result<void> write_file(const std::filesystem::path& path, std::string_view text);
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Whole file in memory; refuses more than max_bytes.
Result<std::string> read_file(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace nav::io
