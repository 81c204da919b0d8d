// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "io/detail/input_file.hpp"
#include "io/detail/scratch_file.hpp"
#include "io/detail/within_memory.hpp"

namespace nav::io {

namespace {

Error failed(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kIo, path.string() + ": cannot " + what + ": " + std::strerror(errno)};
}

/// Follows symbolic links: the file that they point to is replaced, not the link.
Result<std::filesystem::path> behind_links(std::filesystem::path path) {
  constexpr int kMostLinks = 40;  // Limit of the kernel.
  const std::filesystem::path asked = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code code;
    const auto next = std::filesystem::read_symlink(path, code);
    if (code) return path;  // Not a link.
    path = path.parent_path() / next;
  }
  errno = ELOOP;
  return failed(asked, "create");
}

bool is_special(const std::filesystem::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

}  // namespace

Result<AtomicFile> AtomicFile::create(const std::filesystem::path& path) {
  AtomicFile file;
  file.path_ = path;
  std::error_code ignored;  // An invalid path is reported when the file is created.
  if (path.filename().empty() || std::filesystem::is_directory(path, ignored)) {
    return Error{ErrorCode::kIo, path.string() + ": expected the name of a file, found a folder"};
  }
  if (is_special(path)) {
    file.descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file.descriptor_ < 0) return failed(path, "open for writing");
    return file;
  }
  auto target = behind_links(path);
  if (!target) return target.error();
  file.path_ = std::move(*target);
  auto created = detail::create_beside(file.path_, 0644);
  if (!created) return created.error();
  file.temporary_ = std::move(created->name);
  file.descriptor_ = created->descriptor;
  return file;
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this != &other) {
    abandon();
    path_ = std::move(other.path_);
    temporary_ = std::exchange(other.temporary_, {});
    descriptor_ = std::exchange(other.descriptor_, -1);
    size_ = other.size_;
  }
  return *this;
}

AtomicFile::~AtomicFile() { abandon(); }

void AtomicFile::abandon() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  NAV_CHECK(descriptor_ >= 0, path_.string());
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return failed(path_, "write");
    size_ += static_cast<std::uint64_t>(done);
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
  return {};
}

Result<void> AtomicFile::write(std::string_view text) {
  return write(std::as_bytes(std::span(text)));
}

Result<void> AtomicFile::commit() {
  NAV_CHECK(descriptor_ >= 0, path_.string());
  const auto fail = [&](const char* what) {
    const Error error = failed(path_, what);
    abandon();
    return error;
  };
  // Special files (pipes, /dev/null) cannot be synced; this is not an error.
  if (::fsync(descriptor_) != 0 && !temporary_.empty()) return fail("sync");
  if (::close(std::exchange(descriptor_, -1)) != 0) return fail("close");
  if (temporary_.empty()) return {};
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) return fail("rename to its final name");
  temporary_.clear();
  // Syncs the folder entry, so that it survives a power failure. File systems that cannot do it are
  // accepted.
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    ::fsync(descriptor);
    ::close(descriptor);
  }
  return {};
}

void remove_leftovers(const std::filesystem::path& folder) { detail::remove_leftovers(folder); }

Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (const auto ok = file->write(bytes); !ok) return ok;
  return file->commit();
}

Result<void> write_file(const std::filesystem::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text)));
}

Result<std::string> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  const auto file = detail::InputFile::open(path);
  if (!file) return file.error();
  if (static_cast<std::uint64_t>(file->size()) > max_bytes) {
    return Error{ErrorCode::kMalformedData, path.string() + ": expected at most " +
                                                std::to_string(max_bytes) + " bytes, found " +
                                                std::to_string(file->size())};
  }
  return detail::within_memory(
      path, static_cast<double>(file->size()), [&]() -> Result<std::string> {
        std::string content(static_cast<std::size_t>(file->size()), '\0');
        const auto got = file->read_at(0, std::as_writable_bytes(std::span(content)));
        if (!got) return got.error();
        content.resize(*got);
        return content;
      });
}

}  // namespace nav::io
