// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/folder_lock.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <sstream>
#include <string>
#include <string_view>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace nav::app {

struct FolderLock::Held {
  std::filesystem::path file;
  int descriptor = -1;

  Held() = default;
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  ~Held() {
    if (descriptor >= 0) ::close(descriptor);
  }
  /// True if the file still lies in the folder: its last owner removes it.
  [[nodiscard]] bool is_there() const {
    struct stat opened {};
    struct stat named {};
    return ::fstat(descriptor, &opened) == 0 && ::lstat(file.c_str(), &named) == 0 &&
           opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
  }
};

namespace {

constexpr const char* kLockFile = ".sonde-lock";

std::string this_host() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

std::string text_of(long process, const std::string& host) {
  return "process " + std::to_string(process) + "\nhost " + host + "\n";
}

struct Owner {
  long process = 0;
  std::string host;
};

Owner owner_in(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t got = ::pread(descriptor, text.data(), text.size() - 1, 0);
  Owner owner;
  if (got <= 0) return owner;
  std::istringstream words(text.data());
  std::string word;
  words >> word >> owner.process >> word >> owner.host;
  return owner;
}

bool has_ended(const Owner& owner) {
  if (owner.process < 1) return true;  // Its owner was killed before it wrote its number.
  if (owner.host != this_host()) return false;
  return ::kill(static_cast<pid_t>(owner.process), 0) != 0 && errno == ESRCH;
}

Error cannot(const std::filesystem::path& folder, const char* what) {
  return {ErrorCode::kIo, folder.string() + ": expected a folder that can be written to, found: " +
                              what + ": " + std::strerror(errno)};
}

Error is_of_others(const std::filesystem::path& folder) {
  return {ErrorCode::kIo,
          (folder / kLockFile).string() +
              ": expected a lock that Sonde wrote, found a file that it did not write; move it "
              "away or choose another folder"};
}

Error is_held(const std::filesystem::path& folder, const Owner& owner) {
  std::string who = "another run";
  if (owner.process > 0) {
    who += ", process " + std::to_string(owner.process) + " on " + owner.host;
  }
  return {ErrorCode::kIo, folder.string() +
                              ": expected a folder that no other run writes to, found " + who +
                              " (" + (folder / kLockFile).string() + ")"};
}

/// True for a file that is a lock: empty, because its owner was killed before it wrote, or with an
/// owner. Any other file is somebody's.
bool is_lock(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t got = ::pread(descriptor, text.data(), text.size(), 0);
  if (got == 0) return true;
  if (got < 0) return false;
  const std::string_view found(text.data(), static_cast<std::size_t>(got));
  const Owner owner = owner_in(descriptor);
  return owner.process > 0 && found == text_of(owner.process, owner.host);
}

Result<void> write_owner(int descriptor, const std::filesystem::path& folder) {
  const std::string text = text_of(::getpid(), this_host());
  if (::ftruncate(descriptor, 0) != 0) return cannot(folder, "the lock cannot be written");
  const ssize_t done = ::pwrite(descriptor, text.data(), text.size(), 0);
  if (done != static_cast<ssize_t>(text.size())) {
    return cannot(folder, "the lock cannot be written");
  }
  return {};
}

}  // namespace

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    auto held = std::make_unique<Held>();
    held->file = folder / kLockFile;
    held->descriptor = ::open(held->file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (held->descriptor < 0) return cannot(folder, "the lock cannot be created");
    if (::flock(held->descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      if (reason == EINTR) continue;
      const Owner owner = owner_in(held->descriptor);
      if (reason == EWOULDBLOCK || !has_ended(owner)) return is_held(folder, owner);
    }
    if (!held->is_there()) continue;  // Its owner ended between the two calls.
    if (!is_lock(held->descriptor)) return is_of_others(folder);
    if (auto written = write_owner(held->descriptor, folder); !written) {
      ::unlink(held->file.c_str());
      return written.error();
    }
    return FolderLock(std::move(held));
  }
  return is_held(folder, {});
}

FolderLock::FolderLock(std::unique_ptr<Held> held) : held_(std::move(held)) {}
FolderLock::FolderLock(FolderLock&&) noexcept = default;
FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(held_, other.held_);
  return *this;
}
FolderLock::~FolderLock() {
  if (held_ && held_->is_there()) ::unlink(held_->file.c_str());
}

}  // namespace nav::app
