// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace nav::io::detail {

/// A pipe, and the file without a name that holds what came out of it so far.
struct InputFile::Pipe {
  int source = -1;
  std::mutex mutex;
  std::int64_t stored = 0;  ///< Bytes in the file; guarded by the mutex, like the next one.
  bool ended = false;

  ~Pipe() {
    if (source >= 0) ::close(source);
  }
  /// Stores bytes until there are so many, or the pipe has ended.
  Result<void> fetch(std::int64_t wanted, int store, const std::filesystem::path& path);
};

Result<void> InputFile::Pipe::fetch(std::int64_t wanted, int store,
                                    const std::filesystem::path& path) {
  const std::lock_guard lock(mutex);
  std::vector<std::byte> buffer(64 << 10);
  const auto failed = [&](const char* what) {
    return Error{ErrorCode::kIo, path.string() + ": " + what + ": " + std::strerror(errno)};
  };
  while (!ended && stored < wanted) {
    const ssize_t got = ::read(source, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failed("cannot read");
    ended = got == 0;
    for (ssize_t done = 0; done < got;) {
      const ssize_t put =
          ::pwrite(store, buffer.data() + done, static_cast<std::size_t>(got - done),
                   static_cast<off_t>(stored));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return failed("cannot store what came out of the pipe");
      done += put;
      stored += put;
    }
  }
  return {};
}

Finding longer_than_stated(const std::filesystem::path& path, std::int64_t stated_bytes,
                           std::int64_t found_bytes) {
  return {.subject = path.string(),
          .key = "length of the samples",
          .values = {std::to_string(stated_bytes) + " bytes stated",
                     std::to_string(found_bytes) + " bytes found"},
          .used = "the first " + std::to_string(stated_bytes) + " bytes"};
}

InputFile::InputFile() = default;

namespace {

Error cannot_open(const std::filesystem::path& path, int reason) {
  const bool missing = reason == ENOENT || reason == ENOTDIR;
  return {missing ? ErrorCode::kNotFound : ErrorCode::kIo,
          path.string() + ": cannot open: " + std::strerror(reason)};
}

Error became_shorter(const std::filesystem::path& path, std::int64_t expected, std::int64_t found) {
  return {ErrorCode::kIo, path.string() + ": the file became shorter while it was read: expected " +
                              std::to_string(expected) + " bytes, found " + std::to_string(found)};
}

std::int64_t written_ns(const struct stat& status) {
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  return status.st_mtim.tv_sec * kNanosecondsPerSecond + status.st_mtim.tv_nsec;
}

}  // namespace

Result<InputFile> InputFile::open(const std::filesystem::path& path) {
  // Before it is opened: the writer of a pipe would notice.
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return cannot_open(path, errno);
  if (!S_ISREG(status.st_mode)) {
    return Error{ErrorCode::kIo, path.string() + ": expected a file, found a " +
                                     (S_ISDIR(status.st_mode) ? "folder" : "special file")};
  }
  InputFile file;
  file.path_ = path;
  file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.descriptor_ < 0) return cannot_open(path, errno);
  if (::fstat(file.descriptor_, &status) != 0) {
    return Error{ErrorCode::kIo, path.string() + ": cannot stat: " + std::strerror(errno)};
  }
  file.size_ = static_cast<std::int64_t>(status.st_size);
  file.written_ns_ = written_ns(status);
  return file;
}

Result<InputFile> InputFile::open_or_pipe(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISFIFO(status.st_mode)) return open(path);
  InputFile file;
  file.path_ = path;
  file.size_ = std::int64_t{1} << 62;
  file.pipe_ = std::make_unique<Pipe>();
  file.pipe_->source = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.pipe_->source < 0) return cannot_open(path, errno);
  std::error_code no_folder;
  const auto folder = std::filesystem::temp_directory_path(no_folder);
  file.descriptor_ = ::open(no_folder ? "/tmp" : folder.c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC,
                            S_IRUSR | S_IWUSR);
  if (file.descriptor_ < 0) {
    return Error{ErrorCode::kIo, path.string() + ": cannot store what comes out of the pipe: " +
                                     std::strerror(errno)};
  }
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_),
      written_ns_(other.written_ns_),
      pipe_(std::move(other.pipe_)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(written_ns_, other.written_ns_);
  std::swap(pipe_, other.pipe_);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<std::size_t> InputFile::read_at(std::int64_t offset, std::span<std::byte> out) const {
  if (pipe_) {
    const auto ok =
        pipe_->fetch(offset + static_cast<std::int64_t>(out.size()), descriptor_, path_);
    if (!ok) return ok.error();
  }
  return read_stored(offset, out);
}

Result<std::size_t> InputFile::read_some(std::int64_t offset, std::span<std::byte> out) const {
  if (pipe_) {
    if (const auto ok = pipe_->fetch(offset + 1, descriptor_, path_); !ok) return ok.error();
  }
  return read_stored(offset, out);
}

Result<void> InputFile::check_unchanged() const {
  if (pipe_) return {};
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) {
    return Error{ErrorCode::kIo, path_.string() + ": cannot stat: " + std::strerror(errno)};
  }
  if (written_ns(status) == written_ns_) return {};
  if (status.st_size < size_) return became_shorter(path_, size_, status.st_size);
  return Error{ErrorCode::kIo,
               path_.string() +
                   ": the file was written to while it was read: expected a file that stays as "
                   "it is, found another time of its last change"};
}

Result<std::size_t> InputFile::read_stored(std::int64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done,
                                static_cast<off_t>(offset + static_cast<std::int64_t>(done)));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      return Error{ErrorCode::kIo, path_.string() + ": cannot read: " + std::strerror(errno)};
    }
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  const std::int64_t end = offset + static_cast<std::int64_t>(done);
  if (!pipe_ && done < out.size() && end < size_) {
    return became_shorter(path_, size_, std::max<std::int64_t>(end, 0));
  }
  return done;
}

}  // namespace nav::io::detail
