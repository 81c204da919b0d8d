// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "nav/result.hpp"

namespace nav::io::detail {

/// Name of an unfinished file, "sonde-12-0-1f2e3d4c.partial". Its last word is computed from the
/// others, so that a file of the user is not taken for one.
std::string partial_name(std::int64_t process, std::int64_t count);

struct NewFile {
  std::filesystem::path name;
  int descriptor = -1;
};
/// Creates a file with a new name in the folder of \p path. Rejects a path whose file name is too
/// long for the file system.
Result<NewFile> create_beside(const std::filesystem::path& path, unsigned mode);

/// Removes the files of create_beside() in a folder whose processes have ended without removing
/// them. Files of running processes stay, also those of other hosts that share the folder.
void remove_leftovers(const std::filesystem::path& folder);

/// Unnamed file on disk: it is deleted with the object or the process.
class ScratchFile {
 public:
  /// Creates the file in the folder of \p path, so that a full disk is detected early.
  static Result<ScratchFile> create(const std::filesystem::path& path);
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;
  ~ScratchFile();

  Result<void> append(std::span<const std::byte> bytes);
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// Passes all bytes to \p sink in order, in pieces.
  Result<void> read_all(const std::function<Result<void>(std::span<const std::byte>)>& sink) const;

 private:
  ScratchFile() = default;
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

enum class DeflateFormat { kZlib, kGzip };

/// Deflate stream that is fed in pieces. Equal input gives equal output.
class Deflater {
 public:
  using Sink = std::function<Result<void>(std::span<const std::byte>)>;
  static Result<Deflater> create(DeflateFormat format);
  Deflater(Deflater&&) noexcept;
  Deflater& operator=(Deflater&&) noexcept;
  ~Deflater();

  Result<void> write(std::span<const std::byte> bytes, const Sink& sink);
  Result<void> finish(const Sink& sink);

 private:
  struct State;
  explicit Deflater(std::unique_ptr<State> state);
  Result<void> pump(int flush, const Sink& sink);
  std::unique_ptr<State> state_;
};

}  // namespace nav::io::detail
