// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// The line to a tracker. Nothing waits. One thread at a time.
class NdiTransport {
 public:
  virtual ~NdiTransport() = default;
  /// For messages: "/dev/ttyUSB0", "host:port".
  [[nodiscard]] virtual const std::string& name() const = 0;
  /// A serial line has baud rates and BREAK, and begins with 9600 baud.
  [[nodiscard]] virtual bool is_serial() const = 0;
  /// Begins to connect; finish() says the outcome once the descriptor is writable.
  virtual std::optional<TcpFailure> open() = 0;
  virtual std::optional<TcpFailure> finish() = 0;
  virtual void close() noexcept = 0;
  /// Negative: not open.
  [[nodiscard]] virtual int descriptor() const = 0;
  virtual TcpTransfer receive(std::span<std::byte> into) = 0;
  virtual TcpTransfer send(std::span<const std::byte> from) = 0;
  virtual std::optional<TcpFailure> set_baud(int baud) = 0;
  virtual void set_break(bool on) noexcept = 0;
};

std::unique_ptr<NdiTransport> make_ndi_serial(const std::string& path);
/// Finds the address of the host, which may wait for the name service: kNotFound.
Result<std::unique_ptr<NdiTransport>> make_ndi_tcp(const std::string& host, std::uint16_t port);

}  // namespace nav::devices
