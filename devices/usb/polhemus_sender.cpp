// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_sender.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace nav::devices {
namespace {

/// Reading of a pose; absent: it is not seen, or no rigid pose.
std::optional<PolhemusReading> station_reading(const PoseSample& sample) {
  const Eigen::Matrix4d& matrix = sample.pose.tracker_from_body;
  if (sample.pose.status != TrackingStatus::kOk || !matrix.allFinite()) return std::nullopt;
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  const Eigen::Quaterniond q = Eigen::Quaterniond(turn).normalized();
  return PolhemusReading{.position_mm = {matrix(0, 3), matrix(1, 3), matrix(2, 3)},
                         .rotation_wxyz = {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace

PolhemusSender::PolhemusSender(std::vector<std::string> bodies)
    : bodies_(std::move(bodies)), readings_(bodies_.size()) {}

Result<std::unique_ptr<PolhemusSender>> PolhemusSender::start(
    const std::vector<std::string>& bodies, PolhemusFaultPlan plan, const std::string& address,
    std::uint16_t port) {
  if (bodies.empty() || bodies.size() > static_cast<std::size_t>(kMostPolhemusStations)) {
    return Error{ErrorCode::kUsage,
                 "emulated Polhemus tracker: expected 1 to 16 tracked bodies, found " +
                     std::to_string(bodies.size())};
  }
  std::unique_ptr<PolhemusSender> sender(new PolhemusSender(bodies));
  PolhemusEmulatedOptions options;
  options.stations = static_cast<int>(bodies.size());
  options.see = [&it = *sender](int station, std::uint32_t /*frame*/) { return it.see(station); };
  auto emulator = PolhemusEmulator::start(std::move(options), std::move(plan), address, port);
  if (!emulator) return emulator.error();
  sender->emulator_ = *std::move(emulator);
  return sender;
}

std::optional<PolhemusReading> PolhemusSender::see(int station) {
  const std::lock_guard lock(mutex_);
  return std::exchange(readings_[static_cast<std::size_t>(station - 1)], std::nullopt);
}

void PolhemusSender::send(const StreamInfo& stream, const Sample& sample) {
  const auto* pose = std::get_if<PoseSample>(&sample.what);
  const auto body = std::ranges::find(bodies_, stream.name);
  if (pose == nullptr || body == bodies_.end()) return;
  const auto reading = station_reading(*pose);
  const std::lock_guard lock(mutex_);
  readings_[static_cast<std::size_t>(body - bodies_.begin())] = reading;
}

}  // namespace nav::devices
