// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "nav/result.hpp"

namespace nav::io::detail {

struct NewFile {
  std::filesystem::path name;
  int descriptor = -1;
};
/// A new file of another name in the folder of path. Refuses a path whose name is too long for it.
Result<NewFile> create_beside(const std::filesystem::path& path, unsigned mode);

/// Bytes kept on disk under no name: they vanish with the object, or with the process.
class ScratchFile {
 public:
  /// Lives in the folder of path, so that a full disk shows early.
  static Result<ScratchFile> create(const std::filesystem::path& path);
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;
  ~ScratchFile();

  Result<void> append(std::span<const std::byte> bytes);
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// Hands everything over in order, in pieces.
  Result<void> read_all(const std::function<Result<void>(std::span<const std::byte>)>& sink) const;

 private:
  ScratchFile() = default;
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

enum class DeflateFormat { kZlib, kGzip };

/// One deflate stream fed piece by piece. Same bytes in, same bytes out.
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
