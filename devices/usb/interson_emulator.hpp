// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/usb/emulated_faults.hpp"
#include "devices/usb/interson_codec.hpp"
#include "devices/usb/usbip_server.hpp"

namespace nav::devices {

struct IntersonEmulatedOptions {
  /// Samples of an image, line by line; absent: no image has come yet, and nothing is sent. Called
  /// on the emulator's thread.
  std::function<std::optional<IntersonLines>(std::uint64_t image)> see;
};

/// A fault of one image.
enum class IntersonFault {
  kLostLine,    ///< A line is missing.
  kLostImage,   ///< It is left out.
  kLineNumber,  ///< A line has another number.
  kCutLine,     ///< A transfer ends in the middle of a line.
  kEmpty,       ///< An empty transfer comes before it.
  kStall,       ///< A transfer ends with a stall instead; likewise:
  kOverflow,
  kProtocol,
};
using IntersonFaultPlan = EmulatedFaultPlan<IntersonFault>;  ///< Faults of the images.

/// The probe's side of the wire: registers, and images while it is in B-mode with its voltage and
/// its motor on, at the rate of the motor. The lines of an image are sent evenly over its time, as
/// the transducer passes them.
/// inject() and the like are thread-safe; the rest is called by the server.
class IntersonEmulatedProbe final : public UsbEmulatedDevice {
 public:
  IntersonEmulatedProbe(IntersonEmulatedOptions options, IntersonFaultPlan plan);

  void inject(IntersonFault fault, int images);
  void hush(bool silent);
  /// Value of a register; 0: it was not written.
  [[nodiscard]] std::uint8_t reg(std::uint16_t number) const;

  [[nodiscard]] const UsbDescription& description() const override { return description_; }
  void attach(Timestamp now) override;
  UsbReply control(const UsbSetup& setup, std::span<const std::byte> bytes,
                   std::size_t room) override;
  UsbFault take(std::uint8_t endpoint, std::span<const std::byte> bytes, Timestamp now) override;
  std::optional<UsbReply> give(std::uint8_t endpoint, std::size_t room, Timestamp now) override;
  [[nodiscard]] Timestamp due() const override;

 private:
  [[nodiscard]] bool scans() const;
  [[nodiscard]] Duration period() const;
  [[nodiscard]] std::uint8_t reg_now(std::uint16_t number) const;
  /// Makes the transfers of the image that begins at \p begin.
  void make_image(Timestamp begin);

  const IntersonEmulatedOptions options_;
  const UsbDescription description_;

  mutable std::mutex mutex_;  ///< Guards everything below.
  EmulatedFaults<IntersonFault> faults_;
  std::map<std::uint16_t, std::uint8_t> registers_;
  bool silent_ = false;
  Timestamp next_{};  ///< Next image.
  std::uint64_t image_ = 0;
  struct Sent {
    Timestamp due;
    UsbReply reply;
  };
  std::deque<Sent> sent_;  ///< Transfers that were not read yet, in order.
};

/// A probe without hardware, which a USB/IP server exports.
class IntersonEmulator {
 public:
  /// kUnavailable when the address cannot be had.
  static Result<std::unique_ptr<IntersonEmulator>> start(IntersonEmulatedOptions options,
                                                         IntersonFaultPlan plan = {},
                                                         const std::string& address = "127.0.0.1",
                                                         std::uint16_t port = 0);
  [[nodiscard]] UsbipServer& server() { return *server_; }
  [[nodiscard]] IntersonEmulatedProbe& probe() { return *probe_; }

 private:
  IntersonEmulatedProbe* probe_ = nullptr;  ///< The server's.
  std::unique_ptr<UsbipServer> server_;
};

}  // namespace nav::devices
