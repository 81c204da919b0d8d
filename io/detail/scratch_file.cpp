// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/scratch_file.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <optional>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>
#include <zlib.h>

#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

Error failed_scratch(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kIo, path.string() + ": cannot " + what + ": " + std::strerror(errno)};
}

constexpr std::size_t kPieceBytes = 1 << 20;

}  // namespace

std::string partial_name(std::int64_t process, std::int64_t count) {
  const std::string begin = "sonde-" + std::to_string(process) + "-" + std::to_string(count);
  std::uint32_t hash = 2166136261U;  // FNV-1a, 32 bits.
  for (const char c : begin + ", unfinished") {
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  }
  std::array<char, 16> word{};
  std::snprintf(word.data(), word.size(), "-%08x", hash);
  return begin + word.data() + ".partial";
}

Result<NewFile> create_beside(const std::filesystem::path& path, unsigned mode) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 && errno == ENAMETOOLONG)
    return failed_scratch(path, "create");
  static std::atomic<unsigned> counter{0};
  for (;;) {
    // The process number and a counter keep two writers apart. The file's own name is not used,
    // because it may be too long to extend.
    NewFile file{path.parent_path() / partial_name(::getpid(), counter++)};
    file.descriptor = ::open(file.name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (file.descriptor >= 0) {
      // Held until the file is closed, at the latest by the end of the process: remove_leftovers()
      // asks for it. File systems without locks do without.
      ::flock(file.descriptor, LOCK_EX | LOCK_NB);
      return file;
    }
    if (errno != EEXIST) return failed_scratch(path, "create");
  }
}

namespace {

/// Number of the process in a name that create_beside() made; nothing in any other name.
std::optional<pid_t> process_of(const std::string& name) {
  constexpr std::string_view kBegin = "sonde-";
  constexpr std::string_view kEnd = ".partial";
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return std::nullopt;
  const std::string_view middle =
      std::string_view(name).substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  const auto first = middle.find('-');
  const auto last = middle.rfind('-');
  if (first == middle.npos || first == last) return std::nullopt;
  const auto process = parse_int(middle.substr(0, first));
  const auto count = parse_int(middle.substr(first + 1, last - first - 1));
  if (!process || !count || *process < 1 || *count < 0) return std::nullopt;
  if (name != partial_name(*process, *count)) return std::nullopt;
  if (*process > std::numeric_limits<pid_t>::max()) return std::nullopt;
  return static_cast<pid_t>(*process);
}

bool is_left_behind(const std::filesystem::path& file, pid_t process) {
  if (::kill(process, 0) == 0 || errno != ESRCH) return false;
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) return false;
  // A process of another host or container, which has numbers of its own, holds the lock.
  const bool free = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  ::close(descriptor);
  return free;
}

}  // namespace

void remove_leftovers(const std::filesystem::path& folder) {
  std::error_code status;
  std::vector<std::filesystem::path> dead;
  std::filesystem::directory_iterator it(folder, status);
  for (; !status && it != std::filesystem::directory_iterator(); it.increment(status)) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(it->symlink_status(ignored))) continue;
    const auto process = process_of(it->path().filename().string());
    if (process && is_left_behind(it->path(), *process)) dead.push_back(it->path());
  }
  for (const auto& file : dead) std::filesystem::remove(file, status);
}

Result<ScratchFile> ScratchFile::create(const std::filesystem::path& path) {
  const auto created = create_beside(path, 0600);
  if (!created) return created.error();
  ::unlink(created->name.c_str());
  ScratchFile file;
  file.path_ = path;
  file.descriptor_ = created->descriptor;
  return file;
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> ScratchFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::pwrite(descriptor_, bytes.data(), bytes.size(), size_);
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return failed_scratch(path_, "write");
    size_ += done;
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
  return {};
}

Result<void> ScratchFile::read_all(
    const std::function<Result<void>(std::span<const std::byte>)>& sink) const {
  std::vector<std::byte> piece(kPieceBytes);
  for (std::int64_t at = 0; at < size_;) {
    const ssize_t got = ::pread(descriptor_, piece.data(), piece.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return failed_scratch(path_, "read back");
    const auto ok = sink(std::span(piece).first(static_cast<std::size_t>(got)));
    if (!ok) return ok;
    at += got;
  }
  return {};
}

struct Deflater::State {
  z_stream stream{};
  bool started = false;
  std::vector<std::byte> out = std::vector<std::byte>(kPieceBytes);
  ~State() {
    if (started) deflateEnd(&stream);
  }
};

Deflater::Deflater(std::unique_ptr<State> state) : state_(std::move(state)) {}
Deflater::Deflater(Deflater&&) noexcept = default;
Deflater& Deflater::operator=(Deflater&&) noexcept = default;
Deflater::~Deflater() = default;

Result<Deflater> Deflater::create(DeflateFormat format) {
  // Level 3 keeps up with a live recording. 15: largest window; + 16: gzip framing.
  constexpr int kLevel = 3;
  constexpr int kMemory = 8;
  auto state = std::make_unique<State>();
  const int window = format == DeflateFormat::kGzip ? 15 + 16 : 15;
  if (deflateInit2(&state->stream, kLevel, Z_DEFLATED, window, kMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    return Error{ErrorCode::kIo, "zlib cannot start"};
  }
  state->started = true;
  return Deflater(std::move(state));
}

Result<void> Deflater::pump(int flush, const Sink& sink) {
  z_stream& z = state_->stream;
  int code = Z_OK;
  do {
    z.next_out = reinterpret_cast<Bytef*>(state_->out.data());
    z.avail_out = static_cast<uInt>(state_->out.size());
    code = deflate(&z, flush);
    if (code == Z_STREAM_ERROR) return Error{ErrorCode::kIo, "zlib failed"};
    const auto ok = sink(std::span(state_->out).first(state_->out.size() - z.avail_out));
    if (!ok) return ok;
  } while (z.avail_out == 0 || (flush == Z_FINISH && code != Z_STREAM_END));
  return {};
}

Result<void> Deflater::write(std::span<const std::byte> bytes, const Sink& sink) {
  while (!bytes.empty()) {
    const std::size_t now = std::min<std::size_t>(bytes.size(), std::numeric_limits<int>::max());
    state_->stream.next_in =
        const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));  // zlib only reads it.
    state_->stream.avail_in = static_cast<uInt>(now);
    if (const auto ok = pump(Z_NO_FLUSH, sink); !ok) return ok;
    bytes = bytes.subspan(now);
  }
  return {};
}

Result<void> Deflater::finish(const Sink& sink) { return pump(Z_FINISH, sink); }

}  // namespace nav::io::detail
