// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// One frame of a classic CAN bus (ISO 11898-1), or a report of its controller.
struct CanFrame {
  /// Identifier of 11 or 29 bits. Of an error frame: its classes, CAN_ERR_… of <linux/can/error.h>.
  std::uint32_t id = 0;
  bool extended = false;
  bool remote = false;
  bool error = false;
  std::uint8_t size = 0;  ///< Bytes of data, 0 to 8.
  std::array<std::uint8_t, 8> data{};
  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

/// Bytes of a frame in the kernel's layout (struct can_frame).
inline constexpr std::size_t kCanFrameBytes = 16;
std::array<std::byte, kCanFrameBytes> encode_can(const CanFrame& frame);
/// Absent for another number of bytes than kCanFrameBytes, and for more than 8 bytes of data.
std::optional<CanFrame> decode_can(std::span<const std::byte> bytes);

/// Identifiers that a socket receives: those that agree with \p id in the bits of \p mask.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0x7FF;
  bool extended = false;  ///< Identifiers of 29 bits; otherwise of 11.
};

/// Opens a raw socket on an interface, such as "can0", for the frames that pass one of the filters
/// and all error frames. Errors: kNotFound for an interface that is not there, kUnavailable
/// otherwise.
Result<FileDescriptor> open_can(const std::string& interface,
                                const std::vector<CanFilter>& filters);

/// A frame with what the kernel knows of it.
struct CanReceived {
  CanFrame frame;
  Duration age{0};            ///< Time since the kernel took it from the controller.
  std::uint32_t dropped = 0;  ///< Frames that this socket lost so far, as its queue was full.
};
/// Outcome of one receive that does not wait; none of the three: nothing is there.
struct CanReceive {
  std::optional<CanReceived> received{};
  bool malformed = false;
  std::optional<TcpFailure> failure{};
};
CanReceive receive_can(const FileDescriptor& socket);

/// Outcome of one send that does not wait.
struct CanSend {
  bool full = false;  ///< The queue of the interface is full: the frame was not taken.
  std::optional<TcpFailure> failure{};
};
CanSend send_can(const FileDescriptor& socket, const CanFrame& frame);

/// Causes that an error frame gives: "bus_off", "error_passive", "receive_overflow", "no_ack", …;
/// empty: none that is known.
std::vector<const char*> can_error_causes(const CanFrame& frame);

}  // namespace nav::devices
