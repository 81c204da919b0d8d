// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_sender.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace nav::devices {
namespace {

/// Reading of a pose; one that is not seen, or no rigid pose, is missing.
NdiToolReading reading_of(const PoseSample& sample) {
  NdiToolReading reading;
  const Eigen::Matrix4d& matrix = sample.pose.tracker_from_body;
  const bool out = sample.pose.status == TrackingStatus::kOutOfVolume;
  if ((sample.pose.status != TrackingStatus::kOk && !out) || !matrix.allFinite()) return reading;
  reading.presence = NdiPresence::kMeasured;
  reading.out_of_volume = out;
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  const Eigen::Quaterniond q = Eigen::Quaterniond(turn).normalized();
  reading.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
  reading.translation_mm = {matrix(0, 3), matrix(1, 3), matrix(2, 3)};
  reading.error_mm = sample.tracker_error_mm.value_or(0);
  return reading;
}

}  // namespace

NdiSender::NdiSender(std::vector<std::string> bodies)
    : bodies_(std::move(bodies)), readings_(bodies_.size()) {
  for (NdiToolReading& reading : readings_) reading.number = 0;
}

Result<std::unique_ptr<NdiSender>> NdiSender::start(const std::vector<std::string>& bodies,
                                                    NdiEmulatorLine line, NdiFaultPlan plan) {
  constexpr std::size_t kMostTools = 250;
  if (bodies.empty() || bodies.size() > kMostTools) {
    return Error{ErrorCode::kUsage,
                 "emulated NDI tracker: expected 1 to 250 tracked bodies, found " +
                     std::to_string(bodies.size())};
  }
  std::unique_ptr<NdiSender> sender(new NdiSender(bodies));
  NdiEmulatedOptions options;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    options.tools.push_back({.port = static_cast<unsigned>(i + 1)});
  }
  options.firmware = "Sonde tracker";
  options.see = [&it = *sender](std::size_t tool, std::uint32_t /*number*/) {
    return it.see(tool);
  };
  auto emulator = NdiEmulator::start(std::move(options), std::move(line), std::move(plan));
  if (!emulator) return emulator.error();
  sender->emulator_ = *std::move(emulator);
  return sender;
}

NdiToolReading NdiSender::see(std::size_t tool) const {
  const std::lock_guard lock(mutex_);
  return readings_[tool];
}

void NdiSender::send(const StreamInfo& stream, const Sample& sample) {
  const auto* pose = std::get_if<PoseSample>(&sample.what);
  const auto body = std::ranges::find(bodies_, stream.name);
  if (pose == nullptr || body == bodies_.end()) return;
  const std::lock_guard lock(mutex_);
  NdiToolReading& reading = readings_[static_cast<std::size_t>(body - bodies_.begin())];
  const std::uint32_t number = *reading.number + 1;
  reading = reading_of(*pose);
  reading.number = number;
}

}  // namespace nav::devices
