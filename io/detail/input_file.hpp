// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"

namespace nav::io::detail {

/// File open for reading at any 64-bit offset. Reading is thread-safe.
class InputFile {
 public:
  /// Opens a regular file. Rejects paths that are missing, unreadable, or not regular files, and
  /// does not touch a pipe.
  static Result<InputFile> open(const std::filesystem::path& path);
  /// Opens a regular file, as open() does, or a pipe, and waits for its writer. The bytes of a pipe
  /// are kept in a file without a name, so that they can be read at any offset as they come.
  static Result<InputFile> open_or_pipe(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Length of the file when it was opened, bytes; of a pipe, which has none, 2^62.
  [[nodiscard]] std::int64_t size() const { return size_; }
  [[nodiscard]] bool is_pipe() const { return pipe_ != nullptr; }
  /// Fills \p out from \p offset. Returns the number of bytes read (fewer only at the end). kIo
  /// when the file became shorter since it was opened.
  [[nodiscard]] Result<std::size_t> read_at(std::int64_t offset, std::span<std::byte> out) const;
  /// Reads what is there from \p offset, at least one byte: waits only for the first byte of a
  /// pipe. Returns 0 at the end.
  [[nodiscard]] Result<std::size_t> read_some(std::int64_t offset, std::span<std::byte> out) const;
  /// kIo when the file was written to since it was opened: what was read may be of two files. A
  /// pipe is never.
  [[nodiscard]] Result<void> check_unchanged() const;

 private:
  struct Pipe;
  InputFile();
  [[nodiscard]] Result<std::size_t> read_stored(std::int64_t offset,
                                                std::span<std::byte> out) const;
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
  std::int64_t written_ns_ = 0;  ///< Time of the last change before it was opened.
  std::unique_ptr<Pipe> pipe_;   ///< Null for a regular file.
};

/// The finding about a file whose raw samples are longer than stated: a header that nobody states
/// would shift them. Both lengths in bytes.
Finding longer_than_stated(const std::filesystem::path& path, std::int64_t stated_bytes,
                           std::int64_t found_bytes);

}  // namespace nav::io::detail
