// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/usb/emulated_faults.hpp"
#include "devices/usb/polhemus_codec.hpp"
#include "devices/usb/usbip_server.hpp"

namespace nav::devices {

/// Measurement of a station.
struct PolhemusReading {
  std::array<double, 3> position_mm{};
  std::array<double, 4> rotation_wxyz = {1, 0, 0, 0};
  std::int32_t distortion = 0;
  std::uint8_t error = ' ';
};

struct PolhemusEmulatedOptions {
  int stations = 1;            ///< With a sensor: 1, 2, …, up to 16.
  double rate_hz = 240;        ///< Frames a second, [20, 240].
  std::uint32_t first_ms = 0;  ///< The device's clock when a host takes it.
  /// Reading of a station, from 1, in a frame; absent: it has no sensor now. Called on the
  /// emulator's thread.
  std::function<std::optional<PolhemusReading>(int station, std::uint32_t frame)> see;
};

/// A fault of one frame.
enum class PolhemusFault {
  kMagic,        ///< The header of the first message begins with other bytes.
  kCut,          ///< The last bytes are missing.
  kSize,         ///< The first header states another size.
  kFrameNumber,  ///< The first message has another count.
  kNotFinite,    ///< The first position is no number.
  kNoRotation,   ///< The first quaternion is twice as long as it should be.
  kError,        ///< The first station reports an error.
  kDistortion,   ///< The first station reports a distortion of the field.
  kLost,         ///< It is left out.
  kRepeat,       ///< It comes twice.
  kSplit,        ///< It comes in two transfers.
  kEmpty,        ///< An empty transfer comes before it.
  kStall,        ///< The transfer ends with a stall instead; likewise:
  kOverflow,
  kProtocol,
  kRestart,  ///< The device begins anew, as after it was switched off and on, but goes on to send.
};
using PolhemusFaultPlan = EmulatedFaultPlan<PolhemusFault>;  ///< Faults of the frames.

/// The device's side of the wire: answers commands, and sends a frame for each period of time.
/// Before it is told otherwise it measures in inches and writes text, as the device does. inject()
/// and the like are thread-safe; the rest is called by the server.
class PolhemusEmulatedTracker final : public UsbEmulatedDevice {
 public:
  PolhemusEmulatedTracker(PolhemusEmulatedOptions options, PolhemusFaultPlan plan);

  void inject(PolhemusFault fault, int frames);
  void hush(bool silent);
  /// Commands that came, in order.
  [[nodiscard]] std::vector<std::string> commands() const;
  /// True if poses are sent in centimetres.
  [[nodiscard]] bool is_in_centimetres() const;

  [[nodiscard]] const UsbDescription& description() const override { return description_; }
  void attach(Timestamp now) override;
  UsbReply control(const UsbSetup& setup, std::span<const std::byte> bytes,
                   std::size_t room) override;
  UsbFault take(std::uint8_t endpoint, std::span<const std::byte> bytes, Timestamp now) override;
  std::optional<UsbReply> give(std::uint8_t endpoint, std::size_t room, Timestamp now) override;
  [[nodiscard]] Timestamp due() const override;

 private:
  void reset(Timestamp now);
  void obey(const std::string& command, Timestamp now);
  void reply_error(char command, std::uint8_t error);
  void make_frame(Timestamp now);
  PolhemusRecord record_of(int station, const PolhemusReading& reading, Timestamp now) const;
  void append_message(std::vector<std::byte>& out, const PolhemusRecord& record) const;
  void queue(std::vector<std::byte> bytes);

  const PolhemusEmulatedOptions options_;
  const UsbDescription description_;

  mutable std::mutex mutex_;  ///< Guards everything below.
  EmulatedFaults<PolhemusFault> faults_;
  std::vector<std::string> commands_;
  bool silent_ = false;
  std::string command_;  ///< Bytes of a command that has not ended.
  bool binary_ = false, centimetres_ = false, continuous_ = false;
  std::vector<int> items_;  ///< Items of a record.
  Timestamp began_{};       ///< The device's clock showed first_ms.
  Timestamp next_{};        ///< Next frame.
  std::uint32_t frame_ = 0;
  std::deque<UsbReply> replies_;
};

/// A tracker without hardware, which a USB/IP server exports.
class PolhemusEmulator {
 public:
  /// kUsage for options out of range; kUnavailable when the address cannot be had.
  static Result<std::unique_ptr<PolhemusEmulator>> start(PolhemusEmulatedOptions options,
                                                         PolhemusFaultPlan plan = {},
                                                         const std::string& address = "127.0.0.1",
                                                         std::uint16_t port = 0);
  [[nodiscard]] UsbipServer& server() { return *server_; }
  [[nodiscard]] PolhemusEmulatedTracker& tracker() { return *tracker_; }

 private:
  PolhemusEmulatedTracker* tracker_ = nullptr;  ///< The server's.
  std::unique_ptr<UsbipServer> server_;
};

}  // namespace nav::devices
