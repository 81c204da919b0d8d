// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_tracks.hpp"

#include <algorithm>
#include <cmath>

namespace nav::devices {
namespace {

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return text;
}

bool advances(const NdiToolReading& reading, const std::optional<std::uint32_t>& before) {
  constexpr std::uint32_t kHalf = 1U << 31;
  if (!reading.number || !before) return true;
  const std::uint32_t ahead = *reading.number - *before;
  return ahead != 0 && ahead < kHalf;
}

bool is_there(const NdiToolReading& reading) {
  return reading.presence == NdiPresence::kMeasured || reading.presence == NdiPresence::kMissing;
}

}  // namespace

void NdiTracks::begin() {
  for (Track& one : tracks_) one = {.count = one.count};
}

void NdiTracks::assign(const std::vector<NdiSetup::Tool>& tools, const std::string& firmware) {
  counts_at_60_hz_ = lower(firmware).find("polaris") != std::string::npos;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].handle.reset();
    tracks_[i].unplugged = false;
    if (const auto handle = tools[i].handle) tracks_[i].handle = *handle;
  }
}

bool NdiTracks::is_usable(std::size_t stream) const {
  return tracks_[stream].handle.has_value() && !tracks_[stream].unplugged;
}

NdiTracks::Taken NdiTracks::take(const NdiReadings& readings, Timestamp received,
                                 std::vector<Sample>& out) {
  Taken taken;
  for (const NdiToolReading& reading : readings.tools) {
    const auto found = std::ranges::find(tracks_, std::optional(reading.handle), &Track::handle);
    if (found == tracks_.end()) {
      ++taken.undeclared;
      continue;
    }
    const auto stream = static_cast<std::size_t>(found - tracks_.begin());
    if (!is_there(reading)) {
      if (!found->unplugged) taken.unplugged.push_back(stream);
      found->unplugged = true;
    } else if (!advances(reading, found->number)) {
      ++taken.repeats;
    } else {
      found->number = reading.number;
      out.push_back(sample_of(stream, reading, received));
      ++found->count;
    }
  }
  return taken;
}

Sample NdiTracks::sample_of(std::size_t stream, const NdiToolReading& reading,
                            Timestamp received) const {
  Sample sample{.stream = stream, .sequence = tracks_[stream].count, .received = received};
  sample.device_time = time_of(reading);
  if (sample.device_time && reading.number) sample.sequence = *reading.number;
  PoseSample pose{.pose = ndi_pose(reading, received)};
  if (reading.presence == NdiPresence::kMeasured && std::isfinite(reading.error_mm)) {
    pose.tracker_error_mm = reading.error_mm;
  }
  sample.what = std::move(pose);
  return sample;
}

std::optional<DeviceTime> NdiTracks::time_of(const NdiToolReading& reading) const {
  constexpr std::int64_t kHz = 60;
  constexpr std::int64_t kSecond = 1'000'000'000;
  if (reading.time || !counts_at_60_hz_ || !reading.number) return reading.time;
  return DeviceTime(std::chrono::nanoseconds(std::int64_t{*reading.number} * kSecond / kHz));
}

}  // namespace nav::devices
