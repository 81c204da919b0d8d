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

/// File that appears under its name only when it is complete. Bytes go to a temporary file in the
/// same folder; commit() syncs and renames it. Destruction without commit() leaves no file. An
/// existing target that is not a regular file (/dev/full, a pipe) is written directly. If the path
/// is a symbolic link, the file it points to is replaced and the link is kept. Not thread-safe.
class AtomicFile {
 public:
  static Result<AtomicFile> create(const std::filesystem::path& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Appends bytes. Errors: kIo, with the file name and the system's reason (disk full, …).
  Result<void> write(std::span<const std::byte> bytes);
  Result<void> write(std::string_view text);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Syncs and renames. The file is closed in any case.
  Result<void> commit();

 private:
  AtomicFile() = default;
  void abandon() noexcept;
  std::filesystem::path path_;
  std::filesystem::path temporary_;  ///< Empty when the target is written directly.
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Removes unfinished files in a folder ("sonde-12-0-1f2e3d4c.partial") of processes that were
/// killed. Files of running processes stay, also those of other hosts that share the folder.
void remove_leftovers(const std::filesystem::path& folder);

/// Writes the whole content through an AtomicFile.
Result<void> write_file(const std::filesystem::path& path, std::string_view text);
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Reads a whole file into memory; rejects files larger than \p max_bytes.
Result<std::string> read_file(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace nav::io
