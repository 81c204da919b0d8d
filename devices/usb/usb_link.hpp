// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// A USB device by the numbers of its vendor and its product.
struct UsbId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial{};  ///< Serial number; empty: any.
  friend bool operator==(const UsbId&, const UsbId&) = default;
};
/// "usb:0f44:ff20" or "usb:0f44:ff20:SERIAL".
std::string usb_name(const UsbId& id);

/// End of a transfer.
enum class UsbEnd {
  kDone,      ///< Also a short or an empty one.
  kStall,     ///< The endpoint was halted; the link has cleared it, and goes on.
  kOverflow,  ///< The device sent more than there was room for.
  kTimeout,
  kGone,  ///< The device is not there any more; nothing more will come.
  kError,
};
/// Stable name, for counts: "stall", "overflow", …
const char* to_string(UsbEnd end);

/// A transfer that ended.
struct UsbTransfer {
  std::uint8_t endpoint = 0;  ///< Address, such as 0x88; 0: a control transfer.
  UsbEnd end = UsbEnd::kDone;
  std::vector<std::byte> bytes{};  ///< Received; empty for what was sent.
};

/// The eight bytes that begin a control transfer (USB 2.0, 9.3), without the length.
struct UsbSetup {
  std::uint8_t request_type = 0;  ///< Bit 7: the device sends.
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  [[nodiscard]] bool is_in() const { return (request_type & 0x80) != 0; }
};

/// An open device. All functions but the destructor return without waiting. Not thread-safe. The
/// destructor cancels what is under way, waits for its end, and closes the device, in this order.
class UsbLink {
 public:
  UsbLink() = default;
  UsbLink(const UsbLink&) = delete;
  UsbLink& operator=(const UsbLink&) = delete;
  virtual ~UsbLink() = default;

  /// False while a link to another machine is still being made.
  [[nodiscard]] virtual bool is_open() const { return true; }
  /// The descriptor to wait for before attend().
  [[nodiscard]] virtual Watched watched() const = 0;
  /// Takes what has ended, and queues reads again.
  virtual void attend() = 0;
  /// Keeps \p queued transfers of \p bytes waiting at an IN endpoint, so that nothing is lost
  /// between two calls of attend(). A halt of the endpoint is cleared.
  virtual void keep_reading(std::uint8_t endpoint, std::size_t bytes, int queued) = 0;
  /// Queues a transfer to an OUT endpoint.
  virtual void write(std::uint8_t endpoint, std::vector<std::byte> bytes) = 0;
  /// Queues a control transfer. \p bytes: what is sent, or room for what the device sends.
  virtual void control(const UsbSetup& setup, std::vector<std::byte> bytes) = 0;
  /// The next transfer that ended; absent: none yet. Writes that were done are left out.
  virtual std::optional<UsbTransfer> take() = 0;
  /// Waits until all that was queued to be sent has ended, at most \p longest.
  virtual void drain(Duration longest) = 0;
  /// Reason for kGone, if the link knows more than that the device is gone.
  [[nodiscard]] virtual std::optional<TcpFailure> failure() const { return std::nullopt; }
};

/// Opens a device; called for every attempt.
using UsbOpener = std::function<Result<std::unique_ptr<UsbLink>>()>;

}  // namespace nav::devices
