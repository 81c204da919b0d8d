// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "devices/can/can_arm_source.hpp"
#include "devices/can/canopen.hpp"
#include "devices/can/encoder_arm.hpp"

namespace nav::devices {

/// Angles of the joints, rad, at the n-th SYNC.
using ArmMotion = std::function<std::vector<double>(std::uint64_t sync)>;

/// The encoders of an arm without hardware: they answer CANopen messages on a bus. The bus is an
/// interface of the kernel (a virtual one, vcan), or a pair of local sockets that carry the
/// kernel's frames, which needs no kernel with SocketCAN. One thread, joined by the destructor; all
/// functions are thread-safe.
class CanArmEmulator {
 public:
  /// \p arm: with the true zeros. \p profile: number of the device profile that the encoders state.
  static std::unique_ptr<CanArmEmulator> start(ArmModel arm, ArmMotion motion,
                                               std::uint16_t profile = kEncoderProfile);
  /// On an interface. Errors: those of open_can().
  static Result<std::unique_ptr<CanArmEmulator>> start_on(const std::string& interface,
                                                          ArmModel arm, ArmMotion motion);
  ~CanArmEmulator();
  CanArmEmulator(const CanArmEmulator&) = delete;
  CanArmEmulator& operator=(const CanArmEmulator&) = delete;

  /// Opens the other end of the local bus; the end before is closed. Fails while unplugged.
  [[nodiscard]] CanOpener opener();

  /// An encoder does not answer this many SYNC.
  void miss(std::size_t joint, int syncs);
  /// An encoder answers this many SYNC only after a time.
  void delay(std::size_t joint, int syncs, Duration time);
  /// An encoder says and does nothing more, until it is revived.
  void silence(std::size_t joint);
  void revive();
  void reboot(std::size_t joint);
  void emergency(std::size_t joint, const CanEmergency& emergency);
  /// Frames as they are: error frames of the controller, foreign ones.
  void inject(const CanFrame& frame);
  void inject_bytes(const std::vector<std::byte>& bytes);
  /// Takes the bus away, and brings it back.
  void unplug();
  void replug();
  [[nodiscard]] std::uint64_t syncs() const;

 private:
  struct Held {
    Timestamp due;
    CanFrame frame;
  };
  struct Node {
    bool operational = false, silent = false;
    int misses = 0, delays = 0;
    bool with_sync = false;  ///< Its PDO 2 was set to be sent with every SYNC.
    std::uint32_t heartbeat_ms = 0;
    Timestamp next_heartbeat{};
    Duration delay{0};
  };
  CanArmEmulator(ArmModel arm, ArmMotion motion, std::uint16_t profile);
  void run();
  void take(const CanFrame& frame);
  void take_request(std::size_t joint, const SdoRequest& request);
  void take_sync();
  Duration send_due();
  void send(const CanFrame& frame);

  const ArmModel arm_;
  const ArmMotion motion_;
  const std::uint16_t profile_;
  MonotonicClock clock_;
  WakeEvent wake_;

  mutable std::mutex mutex_;  ///< Guards everything below.
  bool stopped_ = false, plugged_ = true;
  FileDescriptor bus_;
  std::vector<Node> nodes_;
  std::vector<Held> held_;
  std::uint64_t syncs_ = 0;

  std::thread thread_;
};

}  // namespace nav::devices
