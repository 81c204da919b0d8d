// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "devices/openigtlink/tcp_socket.hpp"

namespace nav::devices {

/// A serial port by termios: 8 bits, no parity, 1 stop bit, no handshake, and no modem line needed.
/// Works on a pseudo terminal, where baud rate and BREAK have no effect. One thread at a time.
class SerialPort {
 public:
  SerialPort() = default;
  SerialPort(SerialPort&&) = default;
  SerialPort& operator=(SerialPort&&) = default;
  ~SerialPort() { close(); }

  /// Opens it for this program alone, and throws away what came before. Does not wait. Causes:
  /// "absent", "permission", "busy", "not_serial", "error".
  std::optional<TcpFailure> open(const std::string& path, int baud);
  void close() noexcept;
  [[nodiscard]] bool is_open() const { return fd_.is_open(); }
  [[nodiscard]] int descriptor() const { return fd_.get(); }

  /// Any rate > 0; takes effect after what was sent before has gone.
  std::optional<TcpFailure> set_baud(int baud);
  /// Begins or ends BREAK. The caller keeps the time between, which must be 250 ms or more.
  void set_break(bool on) noexcept;
  /// Neither waits. A port that is gone fails with "unplugged".
  TcpTransfer receive(std::span<std::byte> into);
  TcpTransfer send(std::span<const std::byte> from);

 private:
  FileDescriptor fd_;
};

}  // namespace nav::devices
