// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "nav/result.hpp"

namespace nav::app {

/// Right of one run to write into a folder. It lasts as long as the object; the file ".sonde-lock"
/// in the folder then names the process and its host. The system releases the lock of a process
/// that was killed, and the next run takes the file over. On file systems without locks (some
/// network shares) the process in the file counts: if its host is this one and it has ended, the
/// file is taken over.
class FolderLock {
 public:
  /// Errors: kIo when another run holds the folder (with its process and host), or when the file
  /// cannot be written.
  static Result<FolderLock> take(const std::filesystem::path& folder);
  FolderLock(FolderLock&&) noexcept;
  FolderLock& operator=(FolderLock&&) noexcept;
  ~FolderLock();

 private:
  struct Held;
  explicit FolderLock(std::unique_ptr<Held> held);
  std::unique_ptr<Held> held_;
};

}  // namespace nav::app
