// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/usb/usb_link.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// An endpoint of an emulated device, for bulk transfers.
struct UsbEndpoint {
  std::uint8_t address = 0;  ///< Bit 7: the device sends.
  std::uint16_t packet = 512;
};

/// Descriptors of an emulated device with one configuration and one interface.
struct UsbDescription {
  std::uint16_t vendor = 0, product = 0;
  std::string maker{}, name{}, serial{};
  std::vector<UsbEndpoint> endpoints{};
};

/// Outcome of a transfer at an emulated device, as the kernel says it.
enum class UsbFault : int {
  kNone = 0,
  kStall = -32,     ///< EPIPE: the endpoint is halted until the host clears it.
  kProtocol = -71,  ///< EPROTO: a broken cable.
  kOverflow = -75,  ///< EOVERFLOW: more was sent than there was room for.
};
struct UsbReply {
  UsbFault fault = UsbFault::kNone;
  std::vector<std::byte> bytes{};
};

/// A device behind a UsbipServer. The server's thread alone calls these functions.
class UsbEmulatedDevice {
 public:
  virtual ~UsbEmulatedDevice() = default;
  [[nodiscard]] virtual const UsbDescription& description() const = 0;
  /// A host has the device from now on.
  virtual void attach(Timestamp now) = 0;
  /// A control request of the maker. \p bytes: what the host sent; \p room: what it takes.
  virtual UsbReply control(const UsbSetup& setup, std::span<const std::byte> bytes,
                           std::size_t room) = 0;
  /// Takes what the host sent to an OUT endpoint.
  virtual UsbFault take(std::uint8_t endpoint, std::span<const std::byte> bytes, Timestamp now) = 0;
  /// The reply of the device at an IN endpoint now, at most \p room bytes; absent: nothing yet.
  virtual std::optional<UsbReply> give(std::uint8_t endpoint, std::size_t room, Timestamp now) = 0;
  /// Time at which give() has something again.
  [[nodiscard]] virtual Timestamp due() const = 0;
};

}  // namespace nav::devices
