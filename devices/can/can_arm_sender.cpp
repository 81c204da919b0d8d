// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_arm_sender.hpp"

#include <utility>

#include "devices/can/can_socket.hpp"
#include "devices/can/emulated_arm.hpp"

namespace nav::devices {
namespace {

constexpr auto kLate = std::chrono::milliseconds(20);
/// Identifier of no encoder: a time stamp object of CANopen.
constexpr std::uint32_t kForeignId = 0x100;
constexpr CanEmergency kTooWarm{.code = 0x4200, .error_register = 8};
/// No SYNC is answered until the body is seen again.
constexpr int kUntilSeen = 1 << 30;

/// The pose, if the body was seen.
const Eigen::Matrix4d* seen_pose(const PoseSample& sample) {
  const Eigen::Matrix4d& matrix = sample.pose.tracker_from_body;
  return sample.pose.status == TrackingStatus::kOk && matrix.allFinite() ? &matrix : nullptr;
}

}  // namespace

CanArmSender::CanArmSender(std::string body, CanArmFaultPlan plan, CanArmStart start)
    : body_(std::move(body)), start_(std::move(start)), faults_(std::move(plan)) {}

Result<std::unique_ptr<CanArmSender>> CanArmSender::on_interface(const std::string& interface,
                                                                 std::string body,
                                                                 CanArmFaultPlan plan) {
  // An interface that is not there is said now, and not with the first pose.
  if (const auto bus = open_can(interface, {{.id = 0, .mask = 0}}); !bus) return bus.error();
  return std::make_unique<CanArmSender>(
      std::move(body), std::move(plan), [interface](const ArmModel& arm, ArmMotion motion) {
        return CanArmEmulator::start_on(interface, arm, std::move(motion));
      });
}

Result<std::optional<ArmModel>> CanArmSender::send(const StreamInfo& stream, const Sample& sample) {
  const auto* pose = std::get_if<PoseSample>(&sample.what);
  if (pose == nullptr || stream.name != body_) return std::optional<ArmModel>();
  const Eigen::Matrix4d* seen = seen_pose(*pose);
  if (!arm_) {
    if (seen == nullptr) return std::optional<ArmModel>();
    ArmModel arm = emulated_arm(*seen);
    {
      const std::lock_guard lock(mutex_);
      angles_rad_ = emulated_arm_start_rad();
    }
    auto started = start_(arm, [this](std::uint64_t) { return angles(); });
    if (!started) return started.error();
    emulator_ = *std::move(started);
    arm_ = std::move(arm);
    return arm_;
  }
  const auto reached = seen == nullptr ? std::nullopt : angles_at_pose(*arm_, *seen, angles());
  if (!reached) {
    unseen_ = true;
    emulator_->miss(0, kUntilSeen);
    const std::lock_guard lock(mutex_);
    out_of_reach_ += seen != nullptr ? 1 : 0;
    return std::optional<ArmModel>();
  }
  {
    const std::lock_guard lock(mutex_);
    angles_rad_ = *reached;
  }
  if (std::exchange(unseen_, false)) emulator_->miss(0, 0);
  if (in_error_) emulator_->emergency(*std::exchange(in_error_, std::nullopt), {});
  if (const auto fault = faults_.next()) play(*fault);
  return std::optional<ArmModel>();
}

void CanArmSender::play(CanArmFault fault) {
  const std::size_t joint = faults_played_++ % arm_->joints.size();
  switch (fault) {
    case CanArmFault::kMissing:
      return emulator_->miss(joint, 1);
    case CanArmFault::kLate:
      return emulator_->delay(joint, 1, kLate);
    case CanArmFault::kReboot:
      return emulator_->reboot(joint);
    case CanArmFault::kEmergency:
      in_error_ = joint;
      return emulator_->emergency(joint, kTooWarm);
    case CanArmFault::kForeign:
      return emulator_->inject({.id = kForeignId, .size = 6});
  }
}

std::vector<double> CanArmSender::angles() const {
  const std::lock_guard lock(mutex_);
  return angles_rad_;
}

std::uint64_t CanArmSender::syncs() const { return emulator_ ? emulator_->syncs() : 0; }

std::uint64_t CanArmSender::out_of_reach() const {
  const std::lock_guard lock(mutex_);
  return out_of_reach_;
}

}  // namespace nav::devices
