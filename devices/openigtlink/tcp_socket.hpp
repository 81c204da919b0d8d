// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// Owner of a file descriptor; the destructor closes it.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor() { close(); }
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  void close() noexcept;

 private:
  int fd_ = -1;
};

/// Wakes a thread that waits in poll(). signal() may be called from any thread.
class WakeEvent {
 public:
  /// A descriptor that cannot be made is a Bug.
  WakeEvent();
  /// Readable from signal() until clear().
  [[nodiscard]] int get() const { return event_.get(); }
  void signal() const noexcept;
  void clear() const noexcept;

 private:
  FileDescriptor event_;
};

/// Address and port of a TCP peer.
struct TcpEndpoint {
  alignas(8) std::array<std::byte, 128> address{};  ///< A sockaddr.
  std::uint32_t length = 0;
  std::string text;  ///< "host:port" as it was asked for.
};
/// Finds the address of a host by its name or number. Blocks as long as the name service takes.
/// kNotFound for an unknown host.
Result<TcpEndpoint> resolve_tcp(const std::string& host, std::uint16_t port);

/// Failure of a connection.
struct TcpFailure {
  const char*
      cause;  ///< Stable name: "closed", "no_listener", "reset", "timeout", "unreachable", …
  std::string message;  ///< A clause, such as "the peer closed the connection".
};
/// Failure that an errno means.
TcpFailure tcp_failure(int error);

/// Begins to connect without waiting; the socket is writable when it is done. The peer is asked for
/// a sign of life after one second without bytes.
Result<FileDescriptor> begin_tcp_connect(const TcpEndpoint& peer);
/// Outcome of a connection attempt whose socket is writable; absent: connected.
std::optional<TcpFailure> finish_tcp_connect(const FileDescriptor& socket);
/// Fate of a connection whose peer does not take bytes that were sent.
enum class TcpUnsent {
  kFail,  ///< It fails in two seconds.
  kKeep,  ///< It stays as long as the peer answers at all: peer_vanished().
};
/// Sends without delay, and asks a peer that is silent for a sign of life: one that vanished is
/// found in two seconds.
void set_tcp_options(const FileDescriptor& socket, TcpUnsent unsent);
/// True if bytes were sent again and the peer has not answered for two seconds.
bool peer_vanished(const FileDescriptor& socket);

/// A socket that listens. Port 0: the system chooses one. kUnavailable when it cannot be had.
Result<FileDescriptor> listen_tcp(const TcpEndpoint& address);
/// Port that a socket is bound to.
std::uint16_t bound_port(const FileDescriptor& socket);

/// Outcome of one receive or send that does not wait.
struct TcpTransfer {
  std::size_t bytes = 0;  ///< 0 without a failure: nothing could be moved now.
  std::optional<TcpFailure> failure{};
};
TcpTransfer receive_now(const FileDescriptor& socket, std::span<std::byte> into);
TcpTransfer send_now(const FileDescriptor& socket, std::span<const std::byte> from);

/// One descriptor for wait_for().
struct Watched {
  int fd;             ///< Negative: not watched.
  bool read = false;  ///< Also set on return, when it can be read, written or has failed.
  bool write = false;
};
/// Waits until something happens at one of the descriptors, at most \p longest (not negative). The
/// flags then say what can be done.
void wait_for(std::span<Watched> watched, Duration longest);

}  // namespace nav::devices
