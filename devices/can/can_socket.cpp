// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>

namespace nav::devices {
namespace {

static_assert(sizeof(can_frame) == kCanFrameBytes);

TcpFailure can_failure(int error) {
  switch (error) {
    case ENETDOWN:
      return {"interface_down", "the interface is down: ip link set it up"};
    case ENODEV:
    case ENXIO:
      return {"interface_gone", "the interface is gone; plug the adapter in again"};
    default:
      return {"error", std::strerror(error)};
  }
}

Error open_error(const std::string& interface, const char* what, int error) {
  const ErrorCode code =
      error == ENODEV || error == ENXIO ? ErrorCode::kNotFound : ErrorCode::kUnavailable;
  std::string message = interface + ": " + what + ": " + std::strerror(error);
  if (error == EAFNOSUPPORT) message += " (this kernel has no SocketCAN)";
  return {code, message};
}

/// Time since a stamp of the wall clock, at least 0. A clock that was set in between gives 0 rather
/// than a time that cannot be.
Duration age_of(const timespec& stamp) {
  constexpr Duration kLongest = std::chrono::seconds(1);
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const Duration age = std::chrono::seconds(now.tv_sec - stamp.tv_sec) +
                       std::chrono::nanoseconds(now.tv_nsec - stamp.tv_nsec);
  return age > kLongest ? Duration(0) : std::max(age, Duration(0));
}

void read_control(const msghdr& message, CanReceived& into) {
  auto* header = const_cast<msghdr*>(&message);
  for (cmsghdr* one = CMSG_FIRSTHDR(header); one != nullptr; one = CMSG_NXTHDR(header, one)) {
    if (one->cmsg_level != SOL_SOCKET) continue;
    if (one->cmsg_type == SO_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(one), sizeof stamp);
      into.age = age_of(stamp);
    } else if (one->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&into.dropped, CMSG_DATA(one), sizeof into.dropped);
    }
  }
}

}  // namespace

std::array<std::byte, kCanFrameBytes> encode_can(const CanFrame& frame) {
  can_frame raw{};
  raw.can_id = frame.id & (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK);
  if (frame.extended) raw.can_id |= CAN_EFF_FLAG;
  if (frame.remote) raw.can_id |= CAN_RTR_FLAG;
  if (frame.error) raw.can_id |= CAN_ERR_FLAG;
  raw.len = std::min<std::uint8_t>(frame.size, 8);
  std::copy(frame.data.begin(), frame.data.end(), raw.data);
  std::array<std::byte, kCanFrameBytes> bytes{};
  std::memcpy(bytes.data(), &raw, sizeof raw);
  return bytes;
}

std::optional<CanFrame> decode_can(std::span<const std::byte> bytes) {
  if (bytes.size() != kCanFrameBytes) return std::nullopt;
  can_frame raw{};
  std::memcpy(&raw, bytes.data(), sizeof raw);
  if (raw.len > 8) return std::nullopt;
  CanFrame frame;
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.error = (raw.can_id & CAN_ERR_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.size = raw.len;
  std::copy(std::begin(raw.data), std::end(raw.data), frame.data.begin());
  return frame;
}

Result<FileDescriptor> open_can(const std::string& interface,
                                const std::vector<CanFilter>& filters) {
  const unsigned index = ::if_nametoindex(interface.c_str());
  if (index == 0) return open_error(interface, "expected a CAN interface", errno);
  FileDescriptor socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket.is_open()) return open_error(interface, "cannot open a CAN socket", errno);
  std::vector<can_filter> kernel;
  for (const CanFilter& one : filters) {
    kernel.push_back(
        {one.id | (one.extended ? CAN_EFF_FLAG : 0U), one.mask | CAN_EFF_FLAG | CAN_RTR_FLAG});
  }
  const can_err_mask_t errors = CAN_ERR_MASK;
  const int on = 1;
  const auto set = [&](int level, int option, const void* value, std::size_t bytes) {
    return ::setsockopt(socket.get(), level, option, value, static_cast<socklen_t>(bytes)) == 0;
  };
  if (!set(SOL_CAN_RAW, CAN_RAW_FILTER, kernel.data(), kernel.size() * sizeof(can_filter)) ||
      !set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) ||
      !set(SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) ||
      !set(SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on)) {
    return open_error(interface, "cannot set up the CAN socket", errno);
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return open_error(interface, "expected a CAN interface", errno);
  }
  return socket;
}

CanReceive receive_can(const FileDescriptor& socket) {
  std::array<std::byte, CANFD_MTU> bytes{};
  alignas(cmsghdr) std::array<char, 256> control{};
  iovec into{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &into;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  ssize_t got = 0;
  do {
    got = ::recvmsg(socket.get(), &message, MSG_DONTWAIT);
  } while (got < 0 && errno == EINTR);
  if (got < 0) {
    if (errno == EAGAIN || errno == EWOULDBLOCK) return {};
    return {.failure = can_failure(errno)};
  }
  if (got == 0) return {.failure = TcpFailure{"closed", "the other side closed the bus"}};
  const auto frame = decode_can(std::span(bytes).first(static_cast<std::size_t>(got)));
  if (!frame) return {.malformed = true};
  CanReceive received{.received = CanReceived{.frame = *frame}};
  read_control(message, *received.received);
  return received;
}

CanSend send_can(const FileDescriptor& socket, const CanFrame& frame) {
  const auto bytes = encode_can(frame);
  ssize_t sent = 0;
  do {
    sent = ::send(socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  if (sent == static_cast<ssize_t>(bytes.size())) return {};
  if (sent < 0 && (errno == EPIPE || errno == ECONNRESET)) {
    return {.failure = TcpFailure{"closed", "the other side closed the bus"}};
  }
  const bool full = sent < 0 && (errno == ENOBUFS || errno == EAGAIN || errno == EWOULDBLOCK);
  if (full) return {.full = true};
  return {.failure = can_failure(sent < 0 ? errno : EIO)};
}

std::vector<const char*> can_error_causes(const CanFrame& frame) {
  std::vector<const char*> causes;
  if (!frame.error) return causes;
  const auto has = [&](std::uint32_t bit) { return (frame.id & bit) != 0; };
  if (has(CAN_ERR_BUSOFF)) causes.push_back("bus_off");
  if (has(CAN_ERR_RESTARTED)) causes.push_back("restarted");
  if (has(CAN_ERR_ACK)) causes.push_back("no_ack");
  if (has(CAN_ERR_TX_TIMEOUT)) causes.push_back("send_timeout");
  if (has(CAN_ERR_PROT)) causes.push_back("protocol_error");
  if (has(CAN_ERR_BUSERROR)) causes.push_back("bus_error");
  if (has(CAN_ERR_CRTL)) {
    const unsigned state = frame.data[1];
    if ((state & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) {
      causes.push_back("receive_overflow");
    }
    if ((state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
      causes.push_back("error_passive");
    } else if ((state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) {
      causes.push_back("error_warning");
    }
  }
  return causes;
}

}  // namespace nav::devices
