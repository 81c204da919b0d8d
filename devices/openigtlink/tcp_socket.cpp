// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/tcp_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kMostWatched = 64;

const sockaddr* address_of(const TcpEndpoint& endpoint) {
  return reinterpret_cast<const sockaddr*>(endpoint.address.data());
}

void set_int(int fd, int level, int option, int value) {
  // A socket without an option still works; what it lacks shows in the freshness of its streams.
  (void)::setsockopt(fd, level, option, &value, sizeof value);
}

Error socket_error(const std::string& what, const TcpEndpoint& endpoint, int error) {
  return {ErrorCode::kUnavailable, endpoint.text + ": " + what + ": " + tcp_failure(error).message};
}

/// True for a socket that is connected to itself: the system may choose the port that is asked for
/// as that of the client when nothing listens there.
bool connected_to_itself(const FileDescriptor& socket) {
  sockaddr_storage own{}, peer{};
  socklen_t own_length = sizeof own, peer_length = sizeof peer;
  return ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own), &own_length) == 0 &&
         ::getpeername(socket.get(), reinterpret_cast<sockaddr*>(&peer), &peer_length) == 0 &&
         own_length == peer_length && std::memcmp(&own, &peer, own_length) == 0;
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    close();
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

void FileDescriptor::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

WakeEvent::WakeEvent() : event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!event_.is_open()) throw std::system_error(errno, std::generic_category(), "eventfd");
}

void WakeEvent::signal() const noexcept {
  const std::uint64_t one = 1;
  (void)!::write(event_.get(), &one, sizeof one);
}

void WakeEvent::clear() const noexcept {
  std::uint64_t count = 0;
  (void)!::read(event_.get(), &count, sizeof count);
}

Result<TcpEndpoint> resolve_tcp(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  TcpEndpoint endpoint;
  endpoint.text = host + ":" + std::to_string(port);
  const int code = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (code != 0) {
    return Error{ErrorCode::kUnavailable, endpoint.text + ": expected a known host, found: " +
                                              std::string(::gai_strerror(code))};
  }
  // "localhost" is both ::1 and 127.0.0.1, and most servers listen on the latter only.
  const addrinfo* chosen = found;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (one->ai_family == AF_INET) {
      chosen = one;
      break;
    }
  }
  NAV_CHECK(chosen->ai_addrlen <= endpoint.address.size(), chosen->ai_addrlen);
  std::memcpy(endpoint.address.data(), chosen->ai_addr, chosen->ai_addrlen);
  endpoint.length = chosen->ai_addrlen;
  ::freeaddrinfo(found);
  return endpoint;
}

TcpFailure tcp_failure(int error) {
  switch (error) {
    case ECONNREFUSED:
      return {"no_listener", "nothing listens there"};
    case ECONNRESET:
    case EPIPE:
    case ECONNABORTED:
      return {"reset", "the peer broke the connection off"};
    case ETIMEDOUT:
      return {"timeout", "the peer no longer answers"};
    case EHOSTUNREACH:
    case ENETUNREACH:
    case EHOSTDOWN:
    case ENETDOWN:
      return {"unreachable",
              "there is no way to the peer: " + std::generic_category().message(error)};
    case EMFILE:
    case ENFILE:
      return {"descriptors", "no file descriptor is free"};
    default:
      return {"error", std::generic_category().message(error)};
  }
}

void set_tcp_options(const FileDescriptor& socket, TcpUnsent unsent) {
  const int fd = socket.get();
  set_int(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  set_int(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  // One question after 1 s of silence, and 1 s for the answer.
  set_int(fd, IPPROTO_TCP, TCP_KEEPIDLE, 1);
  set_int(fd, IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set_int(fd, IPPROTO_TCP, TCP_KEEPCNT, 1);
  // While bytes are not acknowledged nobody is asked. The limit lies below the two seconds, because
  // it also holds for the question, and is compared when the answer is due.
  if (unsent == TcpUnsent::kFail) set_int(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 1500);
}

bool peer_vanished(const FileDescriptor& socket) {
  constexpr std::uint32_t kLongestSilenceMs = 2000;
  tcp_info info{};
  socklen_t length = sizeof info;
  if (::getsockopt(socket.get(), IPPROTO_TCP, TCP_INFO, &info, &length) != 0) return false;
  return info.tcpi_retransmits > 0 && info.tcpi_last_ack_recv >= kLongestSilenceMs;
}

Result<FileDescriptor> begin_tcp_connect(const TcpEndpoint& peer) {
  FileDescriptor socket(
      ::socket(address_of(peer)->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return socket_error("cannot make a socket", peer, errno);
  set_tcp_options(socket, TcpUnsent::kFail);
  if (::connect(socket.get(), address_of(peer), peer.length) != 0 && errno != EINPROGRESS &&
      errno != EINTR) {
    return socket_error("cannot connect", peer, errno);
  }
  return socket;
}

std::optional<TcpFailure> finish_tcp_connect(const FileDescriptor& socket) {
  int error = 0;
  socklen_t length = sizeof error;
  if (::getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &length) != 0) error = errno;
  if (error != 0) return tcp_failure(error);
  if (connected_to_itself(socket)) return tcp_failure(ECONNREFUSED);
  return std::nullopt;
}

Result<FileDescriptor> listen_tcp(const TcpEndpoint& address) {
  constexpr int kWaitingClients = 16;
  FileDescriptor socket(
      ::socket(address_of(address)->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return socket_error("cannot make a socket", address, errno);
  set_int(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (::bind(socket.get(), address_of(address), address.length) != 0 ||
      ::listen(socket.get(), kWaitingClients) != 0) {
    return socket_error("cannot listen", address, errno);
  }
  return socket;
}

std::uint16_t bound_port(const FileDescriptor& socket) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &length) != 0) return 0;
  // The port has the same offset in IPv4 and IPv6.
  return ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

TcpTransfer receive_now(const FileDescriptor& socket, std::span<std::byte> into) {
  const ssize_t count = ::recv(socket.get(), into.data(), into.size(), MSG_DONTWAIT);
  if (count > 0) return {static_cast<std::size_t>(count)};
  if (count == 0) return {0, TcpFailure{"closed", "the peer closed the connection"}};
  if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return {};
  return {0, tcp_failure(errno)};
}

TcpTransfer send_now(const FileDescriptor& socket, std::span<const std::byte> from) {
  const ssize_t count = ::send(socket.get(), from.data(), from.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count >= 0) return {static_cast<std::size_t>(count)};
  if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return {};
  return {0, tcp_failure(errno)};
}

void wait_for(std::span<Watched> watched, Duration longest) {
  NAV_CHECK(watched.size() <= kMostWatched, watched.size());
  std::array<pollfd, kMostWatched> polled{};
  for (std::size_t i = 0; i < watched.size(); ++i) {
    polled[i].fd = watched[i].fd;
    polled[i].events =
        static_cast<short>((watched[i].read ? POLLIN : 0) | (watched[i].write ? POLLOUT : 0));
  }
  constexpr Duration kLongestWait = std::chrono::hours(1);
  const Duration wait = std::clamp(longest, Duration(0), kLongestWait);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(wait);
  const timespec timeout{.tv_sec = seconds.count(), .tv_nsec = (wait - seconds).count()};
  const int ready = ::ppoll(polled.data(), watched.size(), &timeout, nullptr);
  for (std::size_t i = 0; i < watched.size(); ++i) {
    const int events = ready > 0 && watched[i].fd >= 0 ? polled[i].revents : 0;
    const bool failed = (events & (POLLERR | POLLHUP | POLLNVAL)) != 0;
    watched[i].read = (events & POLLIN) != 0 || failed;
    watched[i].write = (events & POLLOUT) != 0 || failed;
  }
}

}  // namespace nav::devices
