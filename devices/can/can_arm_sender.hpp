// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/can/can_arm_emulator.hpp"
#include "devices/usb/emulated_faults.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Faults of an emulated arm, one for a pose.
enum class CanArmFault {
  kMissing,    ///< An encoder does not answer one SYNC.
  kLate,       ///< An encoder answers one SYNC 20 ms late.
  kReboot,     ///< An encoder restarts.
  kEmergency,  ///< An encoder reports an error, which is gone with the next pose.
  kForeign,    ///< A frame of another device comes.
};
using CanArmFaultPlan = EmulatedFaultPlan<CanArmFault>;

/// Begins the encoders of an arm; called once, for the first pose.
using CanArmStart =
    std::function<Result<std::unique_ptr<CanArmEmulator>>(const ArmModel&, ArmMotion)>;

/// Gives the poses of one body of a session to an emulated arm (emulated_arm()), whose base is the
/// tracker's frame. The arm is placed by the first pose that is seen. While the body is not seen,
/// or where the arm does not reach it, an encoder does not answer. Thread-safe.
class CanArmSender {
 public:
  /// \p body: name of the stream of poses.
  CanArmSender(std::string body, CanArmFaultPlan plan, CanArmStart start);
  /// Encoders on an interface of the kernel, such as "vcan0". Errors: those of open_can().
  static Result<std::unique_ptr<CanArmSender>> on_interface(const std::string& interface,
                                                            std::string body, CanArmFaultPlan plan);

  [[nodiscard]] const std::string& body() const { return body_; }
  /// Shows the newest pose of the body; other streams are left out. Gives the arm when this pose
  /// has placed it. Errors: those of CanArmStart.
  Result<std::optional<ArmModel>> send(const StreamInfo& stream, const Sample& sample);
  [[nodiscard]] std::uint64_t syncs() const;
  /// Poses that the arm did not reach.
  [[nodiscard]] std::uint64_t out_of_reach() const;

 private:
  [[nodiscard]] std::vector<double> angles() const;
  void play(CanArmFault fault);

  const std::string body_;
  const CanArmStart start_;
  EmulatedFaults<CanArmFault> faults_;
  std::optional<ArmModel> arm_;
  bool unseen_ = false;
  std::optional<std::size_t> in_error_;  ///< Joint that has reported an error.
  std::uint64_t faults_played_ = 0;
  mutable std::mutex mutex_;  ///< Guards the rest but the emulator.
  std::vector<double> angles_rad_{};
  std::uint64_t out_of_reach_ = 0;
  std::unique_ptr<CanArmEmulator> emulator_;
};

}  // namespace nav::devices
